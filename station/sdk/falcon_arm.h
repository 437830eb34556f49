#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "common/math/vec.h"

// Kinematics of the Novint Falcon: three legs of a thigh and a parallelogram, so that the grip never turns. After R. E.
// Stamper, "A three degree of freedom parallel manipulator with only translational degrees of freedom" (PhD thesis 97-4,
// University of Maryland, 1997). Dimensions and frame are those of libnifalcon (FalconGeometry.h): m, rad; x right, y up,
// z toward the user. Real-time: safe.
namespace enamel::station::sdk::falcon {

inline constexpr double kThigh_m = 0.060, kShin_m = 0.1025;
// From the shin's joint to the grip's middle, and from the device's axis to the thigh's, along the leg and
// across it.
inline constexpr double kGripAlong_m = 0.01443, kGripAcross_m = -0.025;
inline constexpr double kBaseAlong_m = 0.040, kBaseAcross_m = -0.02309;
inline constexpr double kJoints_m = 2 * 0.01125;  // at both ends of the shin
inline constexpr std::array<double, 3> kLegs_rad = {
    std::numbers::pi * 7 / 12, -std::numbers::pi / 12, -std::numbers::pi * 9 / 12};
// A thigh's turn in a count: 4 * 320 counts a turn of a shaft of 14.25 mm, whose cable runs on 110 mm.
inline constexpr double kRadPerCount = 2 * std::numbers::pi / (4 * 320) * 14.25 / 110;
inline constexpr double kRadAtZero = 35 * std::numbers::pi / 180;
// Of the workspace, whose z is about 0.08 to 0.17 m. From here Newton's steps lead to each of its places.
inline constexpr dvec3 kMiddle_m{0, 0, 0.125};

// By how much each leg's shin is too short for a tip and its thigh's angle. All 0: the legs fit.
struct Misfit {
  dvec3 m;
  dmat3 by_tip;    // column i: the gradient of leg i's by the tip
  dvec3 by_angle;  // of leg i's by its own angle, m/rad; below 0 where its knee is outside
};

// Nothing where the tip is beyond a shin's reach to the side.
inline std::optional<Misfit> MisfitOf(const dvec3& tip_m, const dvec3& angles_rad) noexcept {
  Misfit out;
  for (int i = 0; i < 3; ++i) {
    const double leg = kLegs_rad[static_cast<size_t>(i)];
    const double cos_leg = std::cos(leg), sin_leg = std::sin(leg);
    const double cos_thigh = std::cos(angles_rad[i]), sin_thigh = std::sin(angles_rad[i]);
    // The shin, from knee to grip: along the leg, across it, out of the device.
    const double along =
        cos_leg * tip_m.x + sin_leg * tip_m.y + kGripAlong_m - kBaseAlong_m - kThigh_m * cos_thigh;
    const double across = cos_leg * tip_m.y - sin_leg * tip_m.x + kGripAcross_m - kBaseAcross_m;
    const double ahead = tip_m.z - kThigh_m * sin_thigh;
    const double in_plane = std::hypot(along, ahead), square = kShin_m * kShin_m - across * across;
    if (square <= 0 || in_plane <= 0) return std::nullopt;
    const double shin = std::sqrt(square);
    out.m[i] = in_plane - kJoints_m - shin;
    const double by_along = along / in_plane, by_across = across / shin;
    out.by_tip[i] = {cos_leg * by_along - sin_leg * by_across,
                     sin_leg * by_along + cos_leg * by_across, ahead / in_plane};
    out.by_angle[i] = kThigh_m * (along * sin_thigh - ahead * cos_thigh) / in_plane;
  }
  return out;
}

// The x whose scalar products with the columns of `m` are those. Nothing where no one x is: the legs are
// stretched or folded.
inline std::optional<dvec3> Solve(const dmat3& m, const dvec3& products) noexcept {
  // The columns are of length 1 and more. Within the workspace their volume is above 0.1.
  constexpr double kMinVolume = 1e-3;
  const dvec3 a = glm::cross(m[1], m[2]);
  const double volume = Dot(m[0], a);
  if (std::abs(volume) < kMinVolume) return std::nullopt;
  return (a * products.x + glm::cross(m[2], m[0]) * products.y +
          glm::cross(m[0], m[1]) * products.z) /
         volume;
}

// The tip where the thighs have these angles, by Newton's steps from a tip near it. Nothing where the steps find
// none, or one with a knee inside.
inline std::optional<dvec3> TipOf(const dvec3& angles_rad, const dvec3& near_m) noexcept {
  constexpr int kMaxSteps = 20;
  constexpr double kLongestStep_m = 0.03, kExact_m = 1e-12;
  dvec3 tip = near_m;
  for (int i = 0; i < kMaxSteps; ++i) {
    const auto misfit = MisfitOf(tip, angles_rad);
    if (!misfit) return std::nullopt;
    if (Dot(misfit->m, misfit->m) < kExact_m * kExact_m) {
      const dvec3& knees = misfit->by_angle;
      if (knees.x < 0 && knees.y < 0 && knees.z < 0) return tip;
      return std::nullopt;
    }
    const auto step = Solve(misfit->by_tip, misfit->m);
    if (!step) return std::nullopt;
    tip -= *step * std::min(1.0, kLongestStep_m / std::sqrt(Dot(*step, *step)));
  }
  return std::nullopt;
}

// The thighs' torques, N m, that push the tip with a force, N: the transposed Jacobian of TipOf times the
// force. Nothing where the legs are stretched or folded.
inline std::optional<dvec3> TorquesOf(const dvec3& force_n, const dvec3& tip_m,
                                      const dvec3& angles_rad) noexcept {
  const auto misfit = MisfitOf(tip_m, angles_rad);
  if (!misfit) return std::nullopt;
  // A tip and angles that keep fitting: by_tip * d tip = -by_angle * d angle, leg by leg.
  const auto along_shins = Solve(glm::transpose(misfit->by_tip), force_n);
  if (!along_shins) return std::nullopt;
  return -*along_shins * misfit->by_angle;
}

}  // namespace enamel::station::sdk::falcon
