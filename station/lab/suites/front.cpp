#include "station/lab/suites/front.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

namespace enamel::station::lab {
namespace {

double Extra(const Row& r, const char* name) {
  for (const auto& [what, value] : r.extra) {
    if (what == name) return value;
  }
  return kNotMeasured;
}

bool HasTrial(const Row& r) { return r.m.ticks > 0; }

double SteadyError(const Row& r) {
  // Of both: relative to the target force, and to B times the bur's actual speed.
  return HasTrial(r) ? std::max(r.m.error_max_n, r.m.anchor_error_n) : kNotMeasured;
}
// Only a hand that prescribes velocity times the law: a force hand pushes with the awaited force,
// and an impedance hand's own spring is slower.
double Rise(const Row& r) {
  if (!HasTrial(r) || r.hand != "velocity" || r.m.rise90_floor_s <= 0) return kNotMeasured;
  return r.m.rise90_s < 0 ? kNever : r.m.rise90_s / r.m.rise90_floor_s;
}
double Release(const Row& r) {
  if (!HasTrial(r) || r.hand != "velocity" || r.tau_s <= 0) return kNotMeasured;
  return r.m.release10_s < 0 ? kNever : r.m.release10_s / r.tau_s;
}
double FeltError(const Row& r) { return Extra(r, "felt_error"); }
double Pull(const Row& r) { return Extra(r, "pull_n"); }

// Whether a is as good as b in time and every metric, and better in one.
bool Dominates(const LawPoint& a, const LawPoint& b) {
  bool better = a.ns_per_tick < b.ns_per_tick;
  if (a.ns_per_tick > b.ns_per_tick) return false;
  for (size_t k = 0; k < a.figures.size(); ++k) {
    if (a.figures[k] > b.figures[k]) return false;
    better |= a.figures[k] < b.figures[k];
  }
  return better;
}

void MarkFronts(std::vector<LawPoint>* points) {
  for (LawPoint& p : *points) {
    auto None = [&](auto beats) {
      // A lost law dominates none: its figures were taken while it oscillated.
      return !p.lost && std::none_of(points->begin(), points->end(), [&](const LawPoint& q) {
        return &q != &p && !q.lost && beats(q);
      });
    };
    p.undominated = None([&](const LawPoint& q) { return Dominates(q, p); });
    p.on_front.resize(p.figures.size());
    for (size_t k = 0; k < p.figures.size(); ++k) {
      p.on_front[k] = std::isfinite(p.figures[k]) && None([&](const LawPoint& q) {
                        return q.figures[k] <= p.figures[k] && q.ns_per_tick < p.ns_per_tick;
                      });
    }
  }
}

}  // namespace

const std::vector<Metric>& FrontMetrics() {
  static const std::vector<Metric> kMetrics = {
      {"steady", "steady error, N", 1e-3, &SteadyError},
      {"rise", "rise to 90 % over its floor", 1e-2, &Rise},
      {"release", "release to 10 %, B/Kc", 1e-3, &Release},
      {"felt", "felt error, wandering hand of 1 N/mm", 1e-2, &FeltError},
      {"pull", "pull against withdrawal, N", 1e-3, &Pull}};
  return kMetrics;
}

std::string LawPointName(const Row& r) {
  char rate[32] = "";
  if (r.rate_hz != 1000) std::snprintf(rate, sizeof rate, ", %.1f kHz", r.rate_hz * 1e-3);
  return r.law + (r.estimator == "own" || r.estimator.empty() ? "" : " / " + r.estimator) + rate;
}

std::vector<LawPoint> LawPointsOf(const std::vector<Row>& rows, const std::string& profile) {
  const std::vector<Metric>& metrics = FrontMetrics();
  std::map<std::string, LawPoint> by_name;
  std::vector<bool> measured(metrics.size(), false);
  for (const Row& r : rows) {
    if ((r.suite != "laws" && r.extra.empty()) || r.profile != profile ||
        // Enamel's B of the paper: laws are compared where all of them were measured.
        std::fabs(r.b_n_s_per_mm - 6.5) > 1e-9)
      continue;
    LawPoint& p = by_name[LawPointName(r)];
    if (p.figures.empty()) p.figures.assign(metrics.size(), kNotMeasured);
    p.name = LawPointName(r);
    p.ns_per_tick = std::max(p.ns_per_tick, r.ns_per_tick);
    p.lost |= r.m.unstable || r.m.cycle;
    p.is_default |= r.is_default && r.rate_hz == 1000;
    for (size_t k = 0; k < metrics.size(); ++k) {
      double v = metrics[k].of(r);
      if (std::isnan(v)) continue;
      measured[k] = true;
      p.figures[k] = std::isnan(p.figures[k]) ? v : std::max(p.figures[k], v);
    }
  }
  std::vector<LawPoint> points;
  for (auto& [name, p] : by_name) {
    if (p.ns_per_tick <= 0) continue;
    for (size_t k = 0; k < metrics.size(); ++k) {
      // Not measured while others were: a law must not win by being left out.
      if (std::isnan(p.figures[k])) p.figures[k] = measured[k] ? kNever : kNotMeasured;
    }
    points.push_back(std::move(p));
  }
  MarkFronts(&points);
  return points;
}

}  // namespace enamel::station::lab
