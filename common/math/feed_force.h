#pragma once

#include <cmath>

namespace enamel {

// The force that cutting takes in one direction at the feed v >= 0: coulomb + root sqrt(v) + linear v. SI units.
struct FeedForce {
  double coulomb_n = 0, root_n_sqrt_s_per_m = 0, linear_n_s_per_m = 0;

  double At(double feed_m_per_s) const noexcept {
    return coulomb_n + root_n_sqrt_s_per_m * std::sqrt(feed_m_per_s) +
           linear_n_s_per_m * feed_m_per_s;
  }
};

// How far a spring K, stretched by L along one direction, moves a bur that meets `force` there in time dt: the w that
// makes K (L - w)^2/2 + dt Phi(w/dt) least, Phi' = force. Phi is convex, so there is one, 0 <= w <= L, and two
// stretches lead to two w that are no farther apart. With x = sqrt(w),
//   (K + linear/dt) x^2 + root/sqrt(dt) x = K L - coulomb;
// 0 where the spring pulls no harder than Coulomb's part. Requires: K > 0, dt > 0, all of `force` >= 0. Only + - * /
// and sqrt. Any thread, real-time safe.
inline double FeedUnder(double stiffness_n_per_m, double stretch_m, double dt_s,
                        const FeedForce& force) noexcept {
  const double left_n = stiffness_n_per_m * stretch_m - force.coulomb_n;
  if (!(left_n > 0)) return 0;
  const double a = stiffness_n_per_m + force.linear_n_s_per_m / dt_s;
  const double q = force.root_n_sqrt_s_per_m / std::sqrt(dt_s);
  // Not (-q + sqrt(...)) / (2 a): the difference of two near numbers.
  const double x = 2 * left_n / (q + std::sqrt(q * q + 4 * a * left_n));
  return x * x;
}

}  // namespace enamel
