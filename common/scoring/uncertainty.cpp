#include "common/scoring/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace enamel::scoring {
namespace {

constexpr double kMm = 1e3, kMm2 = 1e6;
// Angles are measured within half a degree (schemas/score.md, "Accuracy").
constexpr double kAngle_deg = 0.5 * 2 * kEven;
// Between two of the 72 places of a finish line.
constexpr double kPlaces_deg = 5;
// The least reduction that a share is taken of, and the least height of a stump.
constexpr double kMinReduction_m = 0.5e-3, kMinStump_m = 1e-3;

// Of a share of the volume `whole_m3` that a surface bounds which errs by as much everywhere.
double OfShare_percent(double area_m2, double whole_m3, double surface_m) {
  return whole_m3 > 0 ? 100 * area_m2 * surface_m / whole_m3 : 0;
}

double OfPercent(std::string_view metric, const Measured& m) {
  const double u = m.surface_u_m;
  if (metric == "contact_left_percent")
    return m.contact ? m.contact->uncertainty_percent(u, m.voxel_m) : 0;
  if (metric == "reduction_top_percent")
    return m.stump.top_asked_m > 0 ? 100 * u / m.stump.top_asked_m : 0;
  if (metric == "reduction_least_percent") return 100 * u / kMinReduction_m;
  if (metric == "stump_left_percent") return 100 * u / kMinStump_m;
  if (metric == "caries_left_percent") {
    const auto caries = static_cast<size_t>(cutting::Tissue::kCaries);
    // A voxel is carious or not, each by itself.
    const double area_m2 = m.caries_area_m2, h = m.voxel_m;
    const double each_m = area_m2 > 0 ? kEven * h * h / std::sqrt(area_m2) : 0;
    return OfShare_percent(area_m2, m.task.task[caries], std::sqrt(u * u + each_m * each_m));
  }
  // A side has a quarter of each.
  return OfShare_percent(m.cut_area_m2, m.task.task_m3(), u);
}

}  // namespace

double SurfaceUncertainty_m(double voxel_m, double registration_m) {
  const double grid = 0.5 * voxel_m * kEven, laid = 2 * registration_m * kEven;
  return std::sqrt(grid * grid + laid * laid);
}

std::optional<double> UncertaintyOf(std::string_view metric, std::string_view unit, double value,
                                    const Measured& m) {
  if (!IsSeenOnTheTooth(metric)) return std::nullopt;
  if (unit == "mm") {
    // A face's median errs as its surface does. An overhang is between the lines of two walls. The others are of a few
    // places: within half a voxel.
    if (metric == "crown_overhang_mm") return std::sqrt(2.0) * m.surface_u_m * kMm;
    const bool of_face =
        metric == "floor_mm" || (metric.starts_with("wall_") && metric != "wall_waviness_mm");
    return (of_face ? 1 : 2) * m.surface_u_m * kMm;
  }
  if (unit == "%") return OfPercent(metric, m);
  // Two ends.
  if (metric == "finish_missing_deg") return std::sqrt(2.0) * kPlaces_deg * kEven;
  if (unit == "deg") return kAngle_deg;
  if (metric == "pulp_exposed_mm2") {
    // Along the edge of a round place, to half a voxel, and whether a voxel's face is there at all.
    const double area_m2 = std::max(0.0, value) / kMm2, h = m.voxel_m;
    return kEven * h * std::sqrt(4 * std::numbers::pi * area_m2 + h * h) * kMm2;
  }
  return std::nullopt;
}

}  // namespace enamel::scoring
