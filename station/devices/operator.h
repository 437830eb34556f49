#pragma once

#include <string>

#include "common/base/check.h"
#include "common/math/orientation.h"
#include "common/math/vec.h"

namespace enamel::station {

// The hand on the device during one tick: a spring and damper to an equilibrium that the operator
// moves, with his mass lumped to the device's. Force on the device = stiffness (equilibrium - x) -
// damping (v - equilibrium velocity), at most max_force.
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

// A simulated person holding a simulated device. Act is called once per tick of tick_s with what
// the operator can know: the position of his hand, and of the bur in the picture now. The operator
// adds his own reaction delay. Real-time: Act is safe. Thread safety: none.
class SimulatedOperator {
 public:
  virtual ~SimulatedOperator() = default;
  virtual std::string Name() const = 0;
  // Where the hand starts.
  virtual dvec3 Start_m() const = 0;
  ENAMEL_REALTIME virtual HandDrive Act(const dvec3& hand_m, const dvec3& bur_m,
                                        double tick_s) noexcept = 0;
  // Share of the plan done, 0..1.
  virtual double Progress() const noexcept = 0;
};

// Nobody: the device is left to itself, starting at the scene's origin.
class NobodyHolding final : public SimulatedOperator {
 public:
  std::string Name() const override { return "nobody"; }
  dvec3 Start_m() const override { return dvec3(0); }
  ENAMEL_REALTIME HandDrive Act(const dvec3&, const dvec3&, double) noexcept override { return {}; }
  double Progress() const noexcept override { return 0; }
};

}  // namespace enamel::station
