#pragma once

#include <algorithm>
#include <cmath>

#include "common/core/core.h"

// A device, a tissue and a hand, for tests of the core.
namespace enamel::test {

inline core::CoreParams ParamsFor(const cutting::Bur& bur) {
  auto nm = [](double m) { return static_cast<int32_t>(m * 1e9 + 0.5); };
  core::CoreParams p;
  p.kc_mn_per_mm = 2500;
  p.resolution_nm = {10'000, 10'000, 10'000};
  p.peak_force_mn = 7900;
  p.bur_shape = bur.shape;
  p.bur_radius_nm = nm(bur.radius_m);
  p.bur_length_nm = nm(bur.length_m);
  p.bur_narrow_radius_nm = nm(bur.narrow_radius_m);
  p.shank_radius_nm = nm(bur.shank_radius_m);
  p.neck_nm = nm(bur.neck_m);
  p.damping_mn_s_per_mm[1] = 6500;
  return p;
}

inline core::TickInput At(double x_m, double y_m, double z_m, uint8_t flags = core::kBurOn) {
  core::TickInput in;
  in.counts = {static_cast<int32_t>(std::lround(x_m / 10e-6)),
               static_cast<int32_t>(std::lround(y_m / 10e-6)),
               static_cast<int32_t>(std::lround(z_m / 10e-6))};
  in.flags = flags;
  return in;
}

// A hand that waits, comes down into a block and then moves sideways through it.
inline core::TickInput Stroke(int tick) {
  double down = std::min(std::max(0, tick - 600) * 1e-6, 1e-3),
         along = std::max(0.0, (tick - 1600) * 0.5e-6);
  return At(along, 0.2e-3 * std::sin(tick * 0.003), 0.2e-3 - down);
}

}  // namespace enamel::test
