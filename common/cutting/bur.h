#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "common/math/orientation.h"
#include "common/math/vec.h"

// Burs as bodies of revolution with analytic signed distance.
namespace enamel::cutting {

// Stable numbers: recorded in attempt headers.
enum class BurShape : uint8_t { kSphere = 1, kCylinder = 2 };

constexpr std::optional<BurShape> BurShapeFromName(std::string_view name) {
  if (name == "sphere") return BurShape::kSphere;
  if (name == "cylinder") return BurShape::kCylinder;
  return std::nullopt;
}
constexpr std::string_view BurShapeName(BurShape shape) {
  return shape == BurShape::kSphere ? "sphere" : "cylinder";
}

// Bur frame: origin at the distal end (the tip the device moves), +z along the axis toward the
// shank. A sphere's centre is at z = radius; a flat-end cylinder spans 0 <= z <= length.
struct Bur {
  BurShape shape = BurShape::kSphere;
  double radius_m = 0;
  double length_m = 0;   // cylinder only

  // Signed distance, negative inside; exact. Real-time: safe.
  double Distance(const dvec3& point_in_bur_m) const noexcept;
  double height_m() const noexcept { return shape == BurShape::kSphere ? 2 * radius_m : length_m; }
};

// Where the bur is. Real-time: safe.
struct Pose {
  dvec3 tip_m{0};        // origin of the bur frame in the scene frame
  Quat orientation;      // scene_from_bur
};

// Sample of the bur's surface for engagement: where, outward normal, and how much area it stands for.
struct SurfacePoint {
  dvec3 position_m;      // bur frame
  dvec3 normal;
  double area_m2;
};

// Points about `spacing_m` apart that cover the cutting surface, at most `max_points`. Bit-identical
// on every machine (no libm trigonometry). Not real-time: called when a core is built.
std::vector<SurfacePoint> SampleSurface(const Bur& bur, double spacing_m, size_t max_points);

}  // namespace enamel::cutting
