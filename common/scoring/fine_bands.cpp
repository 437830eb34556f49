#include "common/scoring/fine_bands.h"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "common/scoring/tolerances.h"

namespace enamel::scoring {
namespace {

constexpr double kAngle_deg = 0.5;

// Errors in voxel edges that are not a quarter, as KnownFaults holds them.
constexpr std::pair<const char*, double> kInVoxels[] = {{"neighbour_depth_mm", 0.5},
                                                        {"remaining_dentin_mm", 0.55},
                                                        {"outline_over_mm", 1},
                                                        {"outline_short_mm", 1}};

// Metrics of the tool's way, which do not depend on voxels.
bool IsOfTheMotion(const std::string& metric) {
  return metric.starts_with("path_") || metric.starts_with("dtw_") ||
         metric.starts_with("frechet_");
}

std::optional<double> ErrorOf(const scene::RubricCriterion& criterion, int32_t voxel_nm) {
  if (criterion.unit == "deg") return kAngle_deg;
  if (criterion.unit != "mm" || IsOfTheMotion(criterion.metric)) return std::nullopt;
  double share = 0.25;
  for (const auto& [metric, in_voxels] : kInVoxels) {
    if (criterion.metric == metric) share = in_voxels;
  }
  return share * voxel_nm * 1e-6;
}

}  // namespace

std::vector<FineBand> FineBands(const scene::Rubric& given, int32_t voxel_nm) {
  const scene::Rubric rubric = WithTolerances(given);
  std::vector<FineBand> out;
  for (const scene::RubricCriterion& criterion : rubric.criteria) {
    const std::optional<double> error = ErrorOf(criterion, voxel_nm);
    if (!error) continue;
    std::optional<double> narrowest;
    for (size_t i = 1; i < criterion.map.size(); ++i) {
      const scene::RubricPoint &from = criterion.map[i - 1], &to = criterion.map[i];
      if (from.share == to.share) continue;
      const double width = to.value - from.value;
      narrowest = std::min(narrowest.value_or(width), width);
    }
    if (narrowest && *narrowest < *error) {
      out.push_back({criterion.metric, criterion.unit, *narrowest, *error});
    }
  }
  return out;
}

std::string FineBandText(const FineBand& band, int32_t voxel_nm) {
  char text[200];
  std::snprintf(text, sizeof text,
                "%s: points change within %.3g %s, and it is known to %.3g %s at voxels of %.3g "
                "mm; differences in between score by chance. Make the band wider",
                band.metric.c_str(), band.band, band.unit.c_str(), band.error, band.unit.c_str(),
                voxel_nm * 1e-6);
  return text;
}

}  // namespace enamel::scoring
