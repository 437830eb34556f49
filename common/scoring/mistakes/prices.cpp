#include "common/scoring/mistakes/prices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "common/scene/price_kinds.h"
#include "common/scoring/uncertainty.h"

namespace enamel::scoring {
namespace {

constexpr double kMm = 1e3, kMm3 = 1e9;

// By Newton from above: + - * / alone, so that every machine has the same. x >= 0.
double CubeRoot(double x) {
  if (!(x > 0)) return 0;
  int exponent = 0;
  const double mantissa = std::frexp(x, &exponent);
  const int third = exponent >= 0 ? (exponent + 2) / 3 : -(-exponent / 3);
  double y = std::ldexp(1.0, third);
  const double scaled = std::ldexp(mantissa, exponent);
  for (int i = 0; i < 60; ++i) {
    const double next = (2 * y + scaled / (y * y)) / 3;
    if (!(next < y)) break;
    y = next;
  }
  return y;
}

// Points, at least, where nothing was cut.
constexpr double kNothingCut = 100;
// Points from which what was not done is to be changed, and redone. Chosen.
constexpr double kNotDoneModify = 2, kNotDoneRedo = 15;

// M, with L of 1: metres as an even layer beyond the leeway.
double EvenLayer_m(double moment_m5, double area_m2) {
  return area_m2 > 0 ? CubeRoot(3 * moment_m5 / area_m2) : 0;
}

// Standard uncertainty of a volume whose surface is known to `surface_m`: a ball's, which has the least surface.
double OfVolume_m3(double volume_m3, double surface_m) {
  constexpr double kBall = 4.835975862;  // (36 pi)^(1/3)
  const double edge_m = CubeRoot(volume_m3);
  return kBall * edge_m * edge_m * surface_m;
}

// 0 to 1 for a share of the task that was not done: a quarter of it costs a tenth, half a half.
double NotDone(double share) {
  const double t = std::clamp(share, 0.0, 1.0);
  return t * t * t * (10 + t * (6 * t - 15));
}

// Points for a percent more.
double NotDoneSlope(double share) {
  const double t = std::clamp(share, 0.0, 1.0);
  return kNothingCut * 30 * t * t * (1 - t) * (1 - t) / 100;
}

State StateOf(double points, double modify, double redo) {
  return points >= redo ? State::kRedo : points >= modify ? State::kModify : State::kAcceptable;
}

RegionCost CostOfOne(const RegionMeasure& measure, const scene::RubricPrice& price) {
  const double over = price.over > 0 ? PriceOf(price, measure.over, price.over) : 0;
  const double left = price.left > 0 ? PriceOf(price, measure.left, price.left) : 0;
  const double lost = std::max(over, left);
  return {over >= left, lost, StateOf(lost, price.modify_points, price.redo_points)};
}

// Points for one more of the measure's unit.
double SlopeOf(const scene::RubricPrice& price, double measure, double size) {
  if (!(size > 0)) return 0;
  const double x = measure / size * price.points / price.most;
  const double root = std::sqrt(1 + x * x);
  return price.points / (size * root * root * root);
}

}  // namespace

std::string_view UnitOf(std::string_view kind) {
  if (kind == whole::kNotDone) return "%";
  const scene::PriceKind* found = scene::FindPriceKind(kind);
  return found == nullptr ? "" : found->unit;
}

std::string_view NameOf(State state) {
  constexpr std::array<std::string_view, 3> kNames = {"acceptable", "modify", "redo"};
  return kNames[static_cast<size_t>(state)];
}

double PriceOf(const scene::RubricPrice& price, double measure, double size) {
  if (!(measure > 0)) return 0;
  const double m = measure / size, x = m * price.points / price.most;
  return price.points * m / std::sqrt(1 + x * x);
}

std::vector<RegionMeasure> MeasuresOf(const AcceptableCut& r, const FaultVolumes& faults) {
  const auto& regions = r.regions();
  std::vector<double> over_m5(regions.size()), left_m5(regions.size());
  double elsewhere_m3 = faults.far_m3;
  for (size_t k = 0; k < r.pieces().size(); ++k) {
    over_m5[r.pieces()[k].region] += faults.over[k].moment_m5;
    left_m5[r.pieces()[k].region] += faults.left[k].moment_m5;
    elsewhere_m3 += faults.elsewhere[k].volume_m3;
  }
  std::vector<RegionMeasure> out;
  const double u = r.surface_u_m();
  double area_m2 = 0;
  for (size_t i = 0; i < regions.size(); ++i) {
    area_m2 += regions[i].area_m2;
    out.push_back({regions[i].name, std::string(NameOf(regions[i].kind)),
                   EvenLayer_m(over_m5[i], regions[i].area_m2) * kMm,
                   EvenLayer_m(left_m5[i], regions[i].area_m2) * kMm, u * kMm});
  }
  auto add = [&](std::string_view kind, double over, double left, double uncertainty) {
    out.push_back({std::string(kind), std::string(kind), over, left, uncertainty});
  };
  constexpr double kNick_m2 = 1e-6;
  add(whole::kElsewhere, elsewhere_m3 * kMm3, 0, OfVolume_m3(elsewhere_m3, u) * kMm3);
  add(whole::kNeighbour, EvenLayer_m(faults.neighbour_moment_m5, kNick_m2) * kMm, 0, u * kMm);
  add(whole::kPulp, faults.pulp_m3 * kMm3, 0, OfVolume_m3(faults.pulp_m3, u) * kMm3);
  if (faults.caries_m3 > 0) {
    add(whole::kCaries, 0, 100 * faults.caries_left_m3 / faults.caries_m3,
        100 * OfVolume_m3(faults.caries_left_m3, u) / faults.caries_m3);
  }
  for (size_t i = 0; r.contact() && i < r.contact()->thirds().size(); ++i) {
    const Contact::Figures of = r.contact()->Of(faults.contact_left_m, i);
    add(whole::kContact, 0, of.closed_percent(),
        of.uncertainty_percent(u, r.initial().spec().voxel_m()));
    out.back().name = r.contact()->thirds()[i].name;
  }
  if (r.task_beyond_m3() > 0) {
    add(whole::kNotDone, 0, 100 * faults.left_beyond_m3 / r.task_beyond_m3(),
        100 * area_m2 * u / r.task_beyond_m3());
  }
  return out;
}

Result<CutCost> CostOf(std::span<const RegionMeasure> measures,
                       const std::vector<scene::RubricPrice>& prices) {
  CutCost out;
  double not_done = 0, variance = 0;
  for (const RegionMeasure& measure : measures) {
    RegionCost& row = out.rows.emplace_back();
    if (measure.kind == whole::kNotDone) {
      not_done = kNothingCut * NotDone(measure.left / 100);
      continue;
    }
    const auto price = std::ranges::find(prices, measure.kind, &scene::RubricPrice::of);
    if (price != prices.end()) {
      row = CostOfOne(measure, *price);
      out.sum += row.lost;
      if (row.lost > 0) {
        const double u =
            measure.uncertainty * (row.over ? SlopeOf(*price, measure.over, price->over)
                                            : SlopeOf(*price, measure.left, price->left));
        variance += u * u;
      }
    } else if (const scene::PriceKind* kind = scene::FindPriceKind(measure.kind);
               kind == nullptr || kind->is_needed) {
      return Status(Code::kInvalidInput,
                    "rubric: expected a price for \"" + measure.kind + "\", which " + measure.name +
                        " of this exercise is; add one to prices",
                    "prices");
    }
  }
  // The larger of two sums that only grow only grows.
  for (size_t i = 0; i < measures.size(); ++i) {
    if (measures[i].kind != whole::kNotDone) continue;
    const double rest = std::max(0.0, not_done - out.sum);
    out.rows[i] = {false, rest, StateOf(not_done, kNotDoneModify, kNotDoneRedo)};
    out.sum += rest;
    // Then it alone makes the sum.
    if (rest > 0) {
      const double u = measures[i].uncertainty * NotDoneSlope(measures[i].left / 100);
      variance = u * u;
    }
  }
  out.uncertainty = std::sqrt(variance);
  return out;
}

Status ValidatePrices(const std::vector<scene::RubricPrice>& prices, const std::string& where) {
  std::set<std::string> seen;
  for (size_t i = 0; i < prices.size(); ++i) {
    const scene::RubricPrice& p = prices[i];
    auto bad = [&](const char* member, const std::string& message) {
      const std::string field = where + "[" + std::to_string(i) + "]." + member;
      return Status(Code::kInvalidInput, "rubric, " + field + ": " + message, field);
    };
    const scene::PriceKind* kind = scene::FindPriceKind(p.of);
    if (kind == nullptr) {
      return bad("of", "nothing that has a price is called \"" + p.of + "\"");
    }
    if (!seen.insert(p.of).second) return bad("of", "\"" + p.of + "\" has a price already");
    auto positive = [](double x) { return std::isfinite(x) && x > 0; };
    if (positive(p.over) != (kind->over != nullptr) ||
        positive(p.left) != (kind->left != nullptr)) {
      return bad(kind->over ? "over" : "left", "expected a size above 0 for each side of " + p.of);
    }
    if (!positive(p.points)) return bad("points", "expected points above 0");
    if (!(p.most >= p.points && p.most <= 1e4)) {
      return bad("most", "expected at least the points at its size, and at most 10000");
    }
    if (kind->over && kind->left && p.over > p.left) {
      return bad("over",
                 "expected at most the size of what was left: it can be mended, and this cannot");
    }
    if (!positive(p.modify_points) || !(p.redo_points > p.modify_points)) {
      return bad("redo_points", "expected more than modify_points, and both above 0");
    }
  }
  return Status::Ok();
}

}  // namespace enamel::scoring
