#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "common/math/orientation.h"
#include "common/math/vec.h"

// Burs as bodies of revolution with analytic signed distance.
namespace enamel::cutting {

// Stable numbers: recorded in attempt headers.
enum class BurShape : uint8_t {
  kSphere = 1,
  kCylinder = 2,
  kCone = 3,          // taper: narrow at the tip
  kInvertedCone = 4,  // wide at the tip
  kPear = 5,          // ball at the tip, tapering to the shank
  kFlame = 6,         // pointed, with a belly
  kWheel = 7,         // disc with a round rim
};

inline constexpr std::array<std::pair<BurShape, std::string_view>, 7> kBurShapeNames = {{
    {BurShape::kSphere, "sphere"},
    {BurShape::kCylinder, "cylinder"},
    {BurShape::kCone, "cone"},
    {BurShape::kInvertedCone, "inverted_cone"},
    {BurShape::kPear, "pear"},
    {BurShape::kFlame, "flame"},
    {BurShape::kWheel, "wheel"},
}};
constexpr std::optional<BurShape> BurShapeFromName(std::string_view name) {
  for (const auto& [shape, known] : kBurShapeNames) {
    if (known == name) return shape;
  }
  return std::nullopt;
}
constexpr std::string_view BurShapeName(BurShape shape) {
  for (const auto& [known, name] : kBurShapeNames) {
    if (known == shape) return name;
  }
  return "unknown";
}

// Bur frame: origin at the distal end (the tip the device moves), +z along the axis toward the
// shank. The cutting part spans 0 <= z <= height_m() and is convex (profile.h).
struct Bur {
  BurShape shape = BurShape::kSphere;
  double radius_m = 0;  // the largest
  double length_m = 0;  // of the cutting part; not used by a sphere
  // The narrow end's: cone at the tip (0: pointed), inverted cone, pear and flame at the shank.
  double narrow_radius_m = 0;
  // A cylinder above the cutting part that does not cut but is a wall; radius 0: none. It begins
  // neck_m above the cutting part, where the bur is too thin to touch anything first.
  double shank_radius_m = 0;
  double neck_m = 0;

  // Signed distance to the cutting part, negative inside; exact. Real-time: safe, but each call
  // builds the outline: keep a Profile where there are many points.
  double Distance(const dvec3& point_in_bur_m) const noexcept;
  double height_m() const noexcept { return shape == BurShape::kSphere ? 2 * radius_m : length_m; }
  bool operator==(const Bur&) const = default;
};

inline constexpr double kShankLength_m = 6e-3;  // as much of it as can reach a tooth

// The error in a bur's proportions, if any: "a pear's length at least twice its radius".
std::optional<std::string_view> WhyImpossible(const Bur& bur) noexcept;

// Where the bur is. Real-time: safe.
struct Pose {
  dvec3 tip_m{0};    // origin of the bur frame in the scene frame
  Quat orientation;  // scene_from_bur
};

// Sample of the bur's surface for engagement: position, outward normal, and the area it represents.
struct SurfacePoint {
  dvec3 position_m;  // bur frame
  dvec3 normal;
  double area_m2;
};

// Points of equal area, about `spacing_m` apart, spread over the cutting surface, at most
// `max_points`; their areas sum to the surface's. Bit-identical on every machine (no libm
// trigonometry). Not real-time: called when a core is built.
std::vector<SurfacePoint> SampleSurface(const Bur& bur, double spacing_m, size_t max_points);
// The same for the shank's side and the shoulder it begins with; none without a shank.
std::vector<SurfacePoint> SampleShank(const Bur& bur, double spacing_m, size_t max_points);

}  // namespace enamel::cutting
