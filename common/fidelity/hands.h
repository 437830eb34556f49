#pragma once

#include <vector>

#include "common/fidelity/plant.h"

// The operators of the suites.
namespace enamel::fidelity {

// Moves at `speed` along `direction` (unit) from time 0 to stop_s, then holds still; with reverse_s
// > 0 it turns back at that time. Prescribes the tip's position.
struct LineMotion {
  dvec3 direction{1, 0, 0};
  double speed_m_per_s = 0;
  double stop_s = 1e9;
  double reverse_s = -1;
  dvec3 start_m{0};
  double tremor_m = 0, tremor_hz = 10;  // amplitude along the direction, sinusoidal

  dvec3 PositionAt(double t_s) const;
  dvec3 SpeedAt(double t_s) const;
};

class VelocityHand final : public Hand {
 public:
  explicit VelocityHand(const LineMotion& motion) : motion_(motion) {}
  Grip At(double t_s) override;

 private:
  LineMotion motion_;
};

// Pushes with a constant force along `direction` until stop_s; a mass and its own damping.
class ForceHand final : public Hand {
 public:
  ForceHand(const dvec3& direction, double force_n, double mass_kg, double damping_n_s_per_m,
            double stop_s = 1e9)
      : force_(direction * force_n), mass_(mass_kg), damping_(damping_n_s_per_m), stop_s_(stop_s) {}
  double mass_kg() const override { return mass_; }
  Grip At(double t_s) override;

 private:
  dvec3 force_;
  double mass_, damping_, stop_s_;
};

// Spring and damper to a line motion, with a mass.
class ImpedanceHand final : public Hand {
 public:
  ImpedanceHand(const LineMotion& motion, double stiffness_n_per_m, double mass_kg,
                double damping_n_s_per_m)
      : motion_(motion),
        stiffness_(stiffness_n_per_m),
        mass_(mass_kg),
        damping_(damping_n_s_per_m) {}
  double mass_kg() const override { return mass_; }
  Grip At(double t_s) override;

 private:
  LineMotion motion_;
  double stiffness_, mass_, damping_;
};

// Prescribes the tip step by step from a list, in ticks; holds the last one. The adversary's hand.
class ScriptedHand final : public Hand {
 public:
  ScriptedHand(std::vector<dvec3> positions_m, double tick_s)
      : positions_(std::move(positions_m)), tick_s_(tick_s) {}
  Grip At(double t_s) override;

 private:
  std::vector<dvec3> positions_;
  double tick_s_;
};

}  // namespace enamel::fidelity
