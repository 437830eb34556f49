#include "common/cutting/voxel_limit.h"

#include <cmath>
#include <cstdio>
#include <vector>

#include "common/cutting/engagement.h"

namespace enamel::cutting {
namespace {

// The largest that was found, rounded up. Edges and ends of a face cost most.
constexpr double Scatter(BurShape shape) {
  switch (shape) {
    case BurShape::kSphere:
      return 1.1;
    case BurShape::kCylinder:
    case BurShape::kCone:
      return 2.0;
    case BurShape::kPear:
      return 1.6;
    case BurShape::kFlame:
      return 1.8;
    case BurShape::kWheel:
      return 1.5;
    case BurShape::kInvertedCone:
      break;
  }
  return 2.3;
}

struct Areas {
  double whole_m2 = 0, front_m2 = 0;
};

Areas AreasOf(const Bur& bur) {
  constexpr size_t kPlenty = 10'000;
  Areas out;
  for (const SurfacePoint& p : SampleSurface(bur, 1e-9, kPlenty)) {
    out.whole_m2 += p.area_m2;
    if (p.position_m.z < bur.height_m() / 2)
      out.front_m2 += p.area_m2 * (1 - p.normal.z * p.normal.z);
  }
  return out;
}

}  // namespace

double VoxelForceError(const Bur& bur, int32_t voxel_nm) {
  const Areas areas = AreasOf(bur);
  const double apart_m = EngagementReader::kSpacing_voxels * voxel_nm * 1e-9;
  const double all = std::fmin(areas.whole_m2 / (apart_m * apart_m), EngagementReader::kMaxPoints);
  return Scatter(bur.shape) / (all * areas.front_m2 / areas.whole_m2);
}

int32_t LargestVoxel_nm(const Bur& bur) {
  const Areas areas = AreasOf(bur);
  const double front = Scatter(bur.shape) / kMaxVoxelForceError;
  if (front * areas.whole_m2 > EngagementReader::kMaxPoints * areas.front_m2) return 0;
  const double apart_m = std::sqrt(areas.front_m2 / front);
  return static_cast<int32_t>(apart_m / EngagementReader::kSpacing_voxels * 1e6) * 1000;
}

std::string BurText(const Bur& bur) {
  char text[96];
  std::string out(BurShapeName(bur.shape));
  auto append = [&](const char* format, double m) {
    std::snprintf(text, sizeof text, format, m * 1e3);
    out += text;
  };
  append(" r %g", bur.radius_m);
  if (bur.narrow_radius_m > 0) append(" to %g", bur.narrow_radius_m);
  if (bur.shape != BurShape::kSphere) append(" x %g", bur.length_m);
  return out + " mm";
}

std::optional<std::string> WhyTooCoarse(const Bur& bur, int32_t voxel_nm, bool graded) {
  const double off = VoxelForceError(bur, voxel_nm);
  if (off <= kMaxVoxelForceError) return std::nullopt;
  char text[300];
  std::snprintf(
      text, sizeof text,
      "voxels of %g um are too coarse for the bur (%s): its force is off by up to %.0f %%, and %s",
      voxel_nm * 1e-3, BurText(bur).c_str(), 100 * off,
      graded ? "graded work may be off by 10 % at most"
             : "beyond 10 % practice teaches a wrong hand");
  std::string out = text;
  const int32_t largest_nm = LargestVoxel_nm(bur);
  if (largest_nm == 0) return out + ". Use a larger bur: no voxel does";
  std::snprintf(text, sizeof text, ". Use voxels of %g um or less", largest_nm * 1e-3);
  return out + text;
}

}  // namespace enamel::cutting
