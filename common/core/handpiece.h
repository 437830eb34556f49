#pragma once

#include "common/base/state_archive.h"
#include "common/core/params.h"

namespace enamel::core {

// A handpiece whose speed falls with the torque on the bur, and with it the rate at which it cuts.
//
// An air turbine's torque falls nearly linearly with its speed, from tau_stall at rest to none at
// the free speed omega_0 (Dyson and Darvell, Journal of Dentistry 27, 1999), so under a tangential
// force F_t at the bur's radius r it settles at omega = omega_0 (1 - r F_t / tau_stall). Stall
// torques up to 2.33 N mm were measured (Brockhurst and Shams, Australian Dental Journal 39, 1994).
// That removal per time at a given force goes with the speed, so that B grows as omega_0 / omega,
// is an assumption. F_t is the drag on the bur's surface where the tissue has a friction (cutting/engagement.h), else a
// share of the resisting force. The rotor's inertia is a lag of first order, J omega_0 / tau_stall: J d omega/dt =
// tau_stall (1 - omega/omega_0) - load. Below kSlowest the bur is taken as stalled at that speed: B is never infinite.
//
// Thread safety: none. Real-time: safe.
class Handpiece {
 public:
  static constexpr double kSlowest = 0.05;

  explicit Handpiece(const CoreParams& p)
      : tangential_permille_(p.handpiece_tangential_permille),
        stall_n_m_(p.handpiece_stall_un_m * 1e-6),
        step_(1.0 / p.rate_hz / (1.0 / p.rate_hz + p.handpiece_lag_us * 1e-6)) {}

  // A tick of a bur of this radius under a resisting force, newtons, and what drags on its surface, newton metres; both
  // 0 while the bur is still or in the air.
  void Step(double resisting_n, double radius_m, double drag_n_m) noexcept {
    if (stall_n_m_ == 0) return;
    const double load_n_m = radius_m * tangential_permille_ * 1e-3 * resisting_n + drag_n_m;
    const double settled = 1 - load_n_m / stall_n_m_;
    ratio_ += ((settled > kSlowest ? settled : kSlowest) - ratio_) * step_;
  }
  // omega / omega_0.
  double speed_ratio() const noexcept { return ratio_; }
  void VisitState(StateArchive& archive) { archive(ratio_); }

 private:
  double tangential_permille_, stall_n_m_, step_;
  double ratio_ = 1;
};

}  // namespace enamel::core
