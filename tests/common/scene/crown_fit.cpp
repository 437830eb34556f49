#include "tests/common/scene/crown_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include "common/surface/surface.h"

namespace enamel::scene {
namespace {

constexpr int kTurns = 16, kCoarseSteps = 25, kFineSteps = 60;
constexpr double kHuber_m = 0.6e-3;

struct Rigid {
  dmat3 turn{1};
  dvec3 shift{0};
  dvec3 operator()(const dvec3& p) const { return turn * p + shift; }
};

dmat3 Turn(const dvec3& axis, double angle) {
  double c = std::cos(angle), s = std::sin(angle);
  dmat3 out(0);
  for (int i = 0; i < 3; ++i) {
    dvec3 e(0);
    e[i] = 1;
    out[i] = e * c + glm::cross(axis, e) * s + axis * (Dot(axis, e) * (1 - c));
  }
  return out;
}

// Turns `from` onto +z.
dmat3 ToUp(const dvec3& from) {
  dvec3 axis = glm::cross(from, dvec3(0, 0, 1));
  double sine = std::sqrt(Dot(axis, axis));
  if (sine < 1e-9) return from.z > 0 ? dmat3(1) : Turn(dvec3(1, 0, 0), std::numbers::pi);
  return Turn(axis / sine, std::atan2(sine, from.z));
}

// Solves the 6 x 6 system in place by elimination with pivots.
std::array<double, 6> Solve(std::array<std::array<double, 7>, 6> a) {
  for (size_t c = 0; c < 6; ++c) {
    size_t best = c;
    for (size_t r = c + 1; r < 6; ++r)
      if (std::abs(a[r][c]) > std::abs(a[best][c])) best = r;
    std::swap(a[c], a[best]);
    for (size_t r = 0; r < 6; ++r) {
      if (r == c) continue;
      double f = a[r][c] / a[c][c];
      for (size_t k = c; k < 7; ++k) a[r][k] -= f * a[c][k];
    }
  }
  std::array<double, 6> x{};
  for (size_t i = 0; i < 6; ++i) x[i] = a[i][6] / a[i][i];
  return x;
}

double Huber(double d) {
  d = std::abs(d);
  return d < kHuber_m ? d * d : kHuber_m * (2 * d - kHuber_m);
}

class Aligner {
 public:
  Aligner(const Scan& scan, const Field& tooth) : scan_(scan), tooth_(tooth) {}

  // One Gauss-Newton step with Huber weights; returns the cost before it.
  double Step(Rigid& pose, size_t stride) const {
    std::array<std::array<double, 7>, 6> a{};
    double cost = 0;
    for (size_t i = 0; i < scan_.points.size(); i += stride) {
      const ScanPoint& s = scan_.points[i];
      dvec3 p = pose(s.position_m);
      double d = tooth_(p).distance_m;
      cost += s.area_m2 * Huber(d);
      dvec3 n = Gradient(p);
      dvec3 arm = glm::cross(p, n);
      double w = s.area_m2 * (std::abs(d) < kHuber_m ? 1 : kHuber_m / std::abs(d));
      const double row[6] = {arm.x, arm.y, arm.z, n.x, n.y, n.z};
      for (size_t r = 0; r < 6; ++r) {
        for (size_t c = 0; c < 6; ++c) a[r][c] += w * row[r] * row[c];
        a[r][6] -= w * row[r] * d;
      }
    }
    double trace = 0;
    for (size_t r = 0; r < 3; ++r) trace += a[r][r];
    for (size_t r = 0; r < 3; ++r) a[r][r] += 1e-4 * trace + 1e-30;
    auto x = Solve(a);
    dvec3 w(x[0], x[1], x[2]);
    double angle = std::sqrt(Dot(w, w));
    dmat3 turn = angle > 1e-12 ? Turn(w / angle, std::min(angle, 0.2)) : dmat3(1);
    pose.turn = turn * pose.turn;
    pose.shift = turn * pose.shift + dvec3(x[3], x[4], x[5]);
    return cost;
  }

 private:
  dvec3 Gradient(const dvec3& p) const {
    constexpr double kStep_m = 40e-6;
    dvec3 g;
    for (int i = 0; i < 3; ++i) {
      dvec3 e(0);
      e[i] = kStep_m;
      g[i] = tooth_(p + e).distance_m - tooth_(p - e).distance_m;
    }
    double n = std::sqrt(Dot(g, g));
    return n > 0 ? g / n : dvec3(0);
  }

  const Scan& scan_;
  const Field& tooth_;
};

struct Weighted {
  double distance, weight;
};
double Quantile(std::vector<Weighted> v, double share) {
  std::sort(v.begin(), v.end(),
            [](const Weighted& a, const Weighted& b) { return a.distance < b.distance; });
  double total = 0, sum = 0;
  for (const Weighted& w : v) total += w.weight;
  for (const Weighted& w : v)
    if ((sum += w.weight) >= share * total) return w.distance;
  return 0;
}

}  // namespace

Scan ReadScan(const std::filesystem::path& file, const dvec3& occlusal) {
  std::ifstream in(file);
  std::vector<dvec3> vertices;
  Scan scan;
  double all = 0, base = 0;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v") {
      dvec3 v;
      words >> v.x >> v.y >> v.z;
      vertices.push_back(v * 1e-3);
    } else if (kind == "f") {
      dvec3 c[3];
      for (dvec3& corner : c) {
        std::string word;
        words >> word;
        corner = vertices.at(static_cast<size_t>(std::stoul(word)) - 1);
      }
      dvec3 n = glm::cross(c[1] - c[0], c[2] - c[0]);
      double twice = std::sqrt(Dot(n, n));
      if (twice == 0) continue;
      all += 0.5 * twice;
      if (Dot(n, occlusal) < -0.5 * twice) {
        base += 0.5 * twice;
        continue;
      }
      scan.points.push_back({(c[0] + c[1] + c[2]) / 3.0, n / twice, 0.5 * twice});
    }
  }
  scan.base_share = all > 0 ? base / all : 0;
  return scan;
}

CrownFit FitCrown(const Scan& scan, const dvec3& occlusal, const Field& tooth, const dvec3& lo_m,
                  const dvec3& hi_m) {
  dvec3 lo(1), hi(-1);
  dmat3 up = ToUp(occlusal);
  for (const ScanPoint& s : scan.points) {
    lo = glm::min(lo, up * s.position_m);
    hi = glm::max(hi, up * s.position_m);
  }
  Aligner aligner(scan, tooth);
  Rigid best;
  double best_cost = 1e9;
  for (int i = 0; i < kTurns; ++i) {
    dmat3 turn = Turn(dvec3(0, 0, 1), 2 * std::numbers::pi * i / kTurns);
    // Middles of the crowns' plans together, tops level.
    Rigid pose{turn * up, {}};
    pose.shift = dvec3(0, 0, hi_m.z) - turn * dvec3(0.5 * (lo.x + hi.x), 0.5 * (lo.y + hi.y), hi.z);
    double cost = 0;
    for (int k = 0; k < kCoarseSteps; ++k) cost = aligner.Step(pose, 7);
    if (cost < best_cost) best_cost = cost, best = pose;
  }
  for (int k = 0; k < kFineSteps; ++k) aligner.Step(best, 1);

  surface::Mesh ours =
      surface::ExtractSurface(BuildVolume(GridAround(lo_m, hi_m, 200'000), tooth, BuildThreads()));
  surface::DistanceQuery to_ours(ours);
  CrownFit fit;
  std::vector<Weighted> there, back;
  double squares = 0, area = 0;
  for (const ScanPoint& s : scan.points) {
    fit.aligned_m.push_back(best(s.position_m));
    double d = to_ours.Distance_m(fit.aligned_m.back(), 5e-3);
    there.push_back({d, s.area_m2});
    squares += s.area_m2 * d * d;
    area += s.area_m2;
    fit.max_m = std::max(fit.max_m, d);
  }
  fit.rms_m = std::sqrt(squares / area);
  fit.p95_m = Quantile(there, 0.95);
  // Back: only from where the nearest scan point looks the same way, above the scan's lower rim.
  for (size_t v = 0; v < ours.position_m.size(); ++v) {
    dvec3 p(ours.position_m[v]), n(ours.normal[v]);
    const ScanPoint* nearest = nullptr;
    double d2 = 1;
    for (const ScanPoint& s : scan.points) {
      dvec3 e = best(s.position_m) - p;
      if (double x = Dot(e, e); x < d2) d2 = x, nearest = &s;
    }
    dvec3 e = p - best(nearest->position_m), m = best.turn * nearest->normal;
    double off = Dot(e, m), along = std::sqrt(std::max(d2 - off * off, 0.0));
    if (Dot(n, m) > 0 && along < 0.3e-3) back.push_back({std::sqrt(d2), 1});
  }
  fit.back_p95_m = Quantile(back, 0.95);
  return fit;
}

}  // namespace enamel::scene
