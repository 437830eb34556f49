#include "common/scoring/mistakes/prices.h"

#include <algorithm>
#include <cmath>

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

struct Moments {
  double over_m5 = 0, left_m5 = 0;
};

// M, with L of 1: metres as an even layer beyond the leeway.
double EvenLayer_m(double moment_m5, double area_m2) {
  return area_m2 > 0 ? CubeRoot(3 * moment_m5 / area_m2) : 0;
}

// 0 to 1 for a share of the task that was not done: a quarter of it costs a tenth, half a half.
double NotDone(double share) {
  const double t = std::clamp(share, 0.0, 1.0);
  return t * t * t * (10 + t * (6 * t - 15));
}

}  // namespace

double PriceCurve::At(double measure) const {
  if (!(measure > 0)) return 0;
  const double x = measure / saturates;
  return points * measure / std::sqrt(1 + x * x);
}

Prices ChosenPrices() {
  Prices p;
  auto set = [&](RegionKind kind, double over_mm, double left_mm, double points, double saturates) {
    p.regions[static_cast<size_t>(kind)] = {over_mm / kMm, left_mm / kMm, {points, saturates}};
  };
  set(RegionKind::kFloor, 0.45, 0.6, 14, 3);
  set(RegionKind::kWall, 0.45, 0.6, 12, 3);
  set(RegionKind::kTable, 0.45, 0.45, 6, 3);
  set(RegionKind::kAxialWall, 0.4, 0.4, 7, 3);
  set(RegionKind::kMargin, 0.3, 0.4, 4, 3);
  set(RegionKind::kFace, 0.3, 0.3, 12, 3);
  set(RegionKind::kLineAngle, 0.6, 0.6, 5, 1.2);
  p.elsewhere = {12, 5};
  p.neighbour = {40, 1};
  p.pulp = {1000, 0.05};
  p.caries = {120, 0.5};
  return p;
}

CutCost CostOf(const AcceptableCut& r, const FaultVolumes& faults, const Prices& prices) {
  const auto& regions = r.regions();
  std::vector<Moments> moments(regions.size());
  double elsewhere_m3 = faults.far_m3, left_beyond_m3 = 0;
  for (size_t k = 0; k < r.pieces().size(); ++k) {
    Moments& sum = moments[r.pieces()[k].region];
    sum.over_m5 += faults.over[k].moment_m5;
    sum.left_m5 += faults.left[k].moment_m5;
    left_beyond_m3 += faults.left[k].beyond_m3;
    elsewhere_m3 += faults.elsewhere_m3[k];
  }
  CutCost out;
  auto add = [&](const RegionCost& row) {
    if (row.points > 0) out.rows.push_back(row);
  };
  for (size_t i = 0; i < regions.size(); ++i) {
    const RegionPrice& price = prices.regions[static_cast<size_t>(regions[i].kind)];
    const double over_m = EvenLayer_m(moments[i].over_m5, regions[i].area_m2);
    const double left_m = EvenLayer_m(moments[i].left_m5, regions[i].area_m2);
    const int number = static_cast<int>(i);
    const RegionCost over{number, Measure::kOver, (over_m + kLeeway_m) * kMm,
                          price.price.At(over_m / price.over_m)};
    const RegionCost left{number, Measure::kLeft, (left_m + kLeeway_m) * kMm,
                          price.price.At(left_m / price.left_m)};
    add(over.points >= left.points ? over : left);
  }
  auto other = [&](Measure measure, double size, const PriceCurve& price) {
    add({-1, measure, size, price.At(size)});
  };
  other(Measure::kElsewhere, elsewhere_m3 * kMm3, prices.elsewhere);
  constexpr double kNick_m2 = 1e-6;
  other(Measure::kNeighbour, EvenLayer_m(faults.neighbour_moment_m5, kNick_m2) * kMm,
        prices.neighbour);
  other(Measure::kPulp, faults.pulp_m3 * kMm3, prices.pulp);
  if (faults.caries_m3 > 0) {
    other(Measure::kCaries, faults.caries_left_m3 / faults.caries_m3, prices.caries);
  }
  for (const RegionCost& row : out.rows) out.sum += row.points;
  // The larger of two sums that only grow only grows.
  if (r.task_beyond_m3() > 0) {
    const double share = left_beyond_m3 / r.task_beyond_m3();
    const double rest = kNothingCut * NotDone(share) - out.sum;
    add({-1, Measure::kNotDone, share, rest});
    out.sum += std::max(0.0, rest);
  }
  return out;
}

}  // namespace enamel::scoring
