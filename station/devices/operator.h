#pragma once

#include <string>

#include "common/base/check.h"
#include "common/math/orientation.h"
#include "common/math/vec.h"

namespace enamel::station {

// The hand on the device during one tick: a spring and damper to an equilibrium the operator moves,
// with his mass lumped to the device's. Force on the device = stiffness (equilibrium - x)
// - damping (v - equilibrium velocity), at most max_force.
struct HandDrive {
  dvec3 equilibrium_m{0};
  dvec3 velocity_m_per_s{0};  // of the equilibrium
  double stiffness_n_per_m = 0;
  double damping_n_s_per_m = 0;
  double max_force_n = 0;
  Quat orientation;  // that the hand holds
  bool pedal = false;
  bool finished = false;  // nothing left to do
};

// Who holds a simulated device. Act is called once per tick of tick_s with what the operator can
// know: where his hand is and where the picture shows the bur now (he reacts to it late by
// himself). Real-time: Act is safe. Thread safety: none.
class SimulatedOperator {
 public:
  virtual ~SimulatedOperator() = default;
  virtual std::string Name() const = 0;
  // Where the hand begins.
  virtual dvec3 Start_m() const = 0;
  ENAMEL_REALTIME virtual HandDrive Act(const dvec3& hand_m, const dvec3& bur_m,
                                        double tick_s) noexcept = 0;
  // Share of the plan done, 0..1.
  virtual double Progress() const noexcept = 0;
};

// Nobody: the device is left to itself, from the scene's origin on.
class NobodyHolding final : public SimulatedOperator {
 public:
  std::string Name() const override { return "nobody"; }
  dvec3 Start_m() const override { return dvec3(0); }
  ENAMEL_REALTIME HandDrive Act(const dvec3&, const dvec3&, double) noexcept override { return {}; }
  double Progress() const noexcept override { return 0; }
};

}  // namespace enamel::station
