#pragma once

#include <array>
#include <optional>

#include "common/cutting/volume.h"

// A tooth as half planes about an upright axis see it. Private to crown.cpp. Deterministic. Thread safety: functions and a
// class that is const after construction.
namespace enamel::scoring::half_planes {

inline constexpr int kPlaces = 72;
inline constexpr int kSections = 8, kHalfPlanes = 2 * kSections;
// A turn is 72 steps of 5 degrees: the directions do not depend on libm.
inline constexpr double kCosStep = 0.99619469809174553, kSinStep = 0.08715574274765817;
// And of 22.5: between every other half plane and the one before, which is one of the places.
inline constexpr double kCosBetween = 0.92387953251128674, kSinBetween = 0.38268343236508977;
inline constexpr double kReach_m = 9e-3;  // a molar's half diagonal and room

struct Direction {
  double x = 1, y = 0;
};

inline Direction Turned(const Direction& d, double cosine, double sine) {
  return {d.x * cosine - d.y * sine, d.x * sine + d.y * cosine};
}
inline std::array<Direction, kPlaces> Directions() {
  std::array<Direction, kPlaces> out;
  for (size_t k = 1; k < out.size(); ++k) out[k] = Turned(out[k - 1], kCosStep, kSinStep);
  return out;
}
inline std::array<Direction, kHalfPlanes> HalfPlanes(const std::array<Direction, kPlaces>& places) {
  std::array<Direction, kHalfPlanes> out;
  for (size_t k = 0; k < out.size(); ++k) {
    const Direction& d = places[k / 2 * (kPlaces / kSections)];
    out[k] = k % 2 == 0 ? d : Turned(d, kCosBetween, kSinBetween);
  }
  return out;
}

// Half planes about an axis through a volume.
class Profile {
 public:
  Profile(const cutting::Volume& volume, const dvec3& axis_m)
      : volume_(volume), axis_m_(axis_m), step_m_(0.5 * volume.spec().voxel_m()) {}

  // Where the tooth ends outwards from the axis at a height; none where the axis is in the air.
  std::optional<double> Radius_m(const Direction& d, double z_m) const {
    double before = At(d, 0, z_m);
    if (before >= 0) return std::nullopt;
    for (double r = step_m_; r < kReach_m; r += step_m_) {
      const double phi = At(d, r, z_m);
      // A neighbour that touches is another tooth.
      if (phi < 0 && IsNeighbour(d, r, z_m)) return r - step_m_;
      if (phi >= 0) return r - step_m_ * phi / (phi - before);
      before = phi;
    }
    return std::nullopt;
  }

  // Height of the surface from above, between two heights; none where there is none.
  std::optional<double> Height_m(const Direction& d, double r_m, double from_z_m,
                                 double to_z_m) const {
    return HeightWhere_m(
        d, [r_m](double) { return r_m; }, from_z_m, to_z_m);
  }
  // Height_m along a line whose distance from the axis follows the height.
  template <typename RadiusAt>
  std::optional<double> HeightWhere_m(const Direction& d, const RadiusAt& radius_m, double from_z_m,
                                      double to_z_m) const {
    double before = At(d, radius_m(from_z_m), from_z_m);
    if (before < 0) return std::nullopt;
    for (double z = from_z_m - step_m_; z > to_z_m; z -= step_m_) {
      const double phi = At(d, radius_m(z), z);
      if (phi < 0) return z + step_m_ * phi / (phi - before);
      before = phi;
    }
    return std::nullopt;
  }
  bool IsSolid(const Direction& d, double r_m, double z_m) const { return At(d, r_m, z_m) < 0; }

  double step_m() const { return step_m_; }

 private:
  dvec3 Point(const Direction& d, double r_m, double z_m) const {
    return {axis_m_.x + r_m * d.x, axis_m_.y + r_m * d.y, z_m};
  }
  double At(const Direction& d, double r_m, double z_m) const {
    return volume_.DistanceAt_m(Point(d, r_m, z_m));
  }
  bool IsNeighbour(const Direction& d, double r_m, double z_m) const {
    return volume_.TissueAtPoint(Point(d, r_m, z_m)) == cutting::Tissue::kNeighbour;
  }

  const cutting::Volume& volume_;
  const dvec3 axis_m_;
  const double step_m_;
};

}  // namespace enamel::scoring::half_planes
