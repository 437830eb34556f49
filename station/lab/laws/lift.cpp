#include "station/lab/laws/lift.h"

#include <algorithm>
#include <cmath>

#include "common/haptics/coupling.h"

namespace enamel::station::lab {
namespace {

constexpr double kHand_kg = 0.1, kAfter_s = 1, kRampUp_s = 0.5, kMinGrip = 0.05;
// Of the wall along the lift: beyond it the bur is out.
constexpr double kWallHeight_m = 1.5e-3;

// Tissue that resists what moves into it along +x, as the side of a slot does.
class Wall final : public haptics::Material {
 public:
  explicit Wall(double b) : b_(b) {}
  haptics::Contact ContactAt(const dvec3& anchor, const dvec3& stretch) noexcept override {
    haptics::Contact c;
    c.clearance_m = 1;
    if (anchor.z < kWallHeight_m && stretch.x > 0) {
      c.damping_n_s_per_m = Sym3::Outer(dvec3(1, 0, 0), b_);
      c.engaged = true;
    }
    return c;
  }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}

 private:
  double b_;
};

class LiftingHand final : public Hand {
 public:
  LiftingHand(const Lift& lift, const dvec3& start, double device_kg, double from_s)
      : lift_(lift),
        start_(start),
        from_s_(from_s),
        damping_(1.2 * std::sqrt(lift.hand_n_per_m * (kHand_kg + device_kg))),
        ahead_m_(lift.b_n_s_per_m * lift.cut_m_per_s / lift.hand_n_per_m) {}
  double mass_kg() const override { return kHand_kg; }
  // Pushes with B v from half a second on, and follows the cut.
  Grip At(double t_s) override {
    const double t = std::min(t_s, from_s_);
    Grip grip;
    grip.equilibrium_m = start_;
    grip.equilibrium_m.x += lift_.cut_m_per_s * t + ahead_m_ * std::min(1.0, t / kRampUp_s);
    grip.equilibrium_speed_m_per_s.x = lift_.cut_m_per_s;
    grip.stiffness_n_per_m = lift_.hand_n_per_m;
    grip.damping_n_s_per_m = damping_;
    if (t_s <= from_s_) return grip;
    const double since = t_s - from_s_;
    const double left = std::max(kMinGrip, std::exp(-since / lift_.relax_s));
    grip.stiffness_n_per_m *= left;
    grip.damping_n_s_per_m *= std::sqrt(left);
    grip.equilibrium_m += Along() * (lift_.speed_m_per_s * since);
    grip.equilibrium_speed_m_per_s = Along() * lift_.speed_m_per_s;
    return grip;
  }
  dvec3 Along() const { return lift_.upward ? dvec3(0, 0, 1) : dvec3(-1, 0, 0); }

 private:
  const Lift& lift_;
  dvec3 start_;
  double from_s_, damping_, ahead_m_;
};

}  // namespace

LiftFigures RunLift(const DeviceModel& m, const Lift& lift) {
  const double from_s = 2 + 2.3 * lift.b_n_s_per_m / m.kc_n_per_m;
  const dvec3 start(3.3e-6, 2.1e-6, 1.1e-6);
  LiftingHand hand(lift, start, m.mass_kg, from_s);
  const TrialSpec spec = SpecOf(m, lift.law, lift.b_n_s_per_m, 0);
  Plant plant(spec.plant, hand, start);
  haptics::CouplingParams params;
  params.law = spec.law;
  params.peak_force_n = spec.peak_force_n;
  haptics::Coupling coupling(params);
  Wall wall(lift.b_n_s_per_m);
  coupling.Reset(plant.Read());
  const double swing = std::max(0.15, 2 * m.kc_n_per_m * m.resolution_m);
  LiftFigures out;
  double lowest = 0, highest = 0;
  bool rising = false;
  while (plant.time_s() < from_s + kAfter_s) {
    const dvec3 r = -coupling.Tick(plant.Read(), 1, wall).force_sent_n;
    plant.Step(-r);
    const double size = glm::length(r);
    if (plant.time_s() <= from_s) {
      out.cut_n = lowest = size;
      continue;
    }
    if (Dot(plant.speed_m_per_s(), hand.Along()) > 0)
      out.pull_n = std::max(out.pull_n, Dot(r, hand.Along()));
    if (!rising) {
      lowest = std::min(lowest, size);
      if (size > lowest + swing) {
        rising = true;
        highest = size;
        ++out.rises;
      }
    } else {
      highest = std::max(highest, size);
      if (size < highest - swing) {
        rising = false;
        lowest = size;
      }
    }
  }
  return out;
}

std::vector<Lift> AllLifts(haptics::LawKind law) {
  std::vector<Lift> all;
  for (double hand : {300.0, 700.0, 1000.0, 2000.0}) {
    for (double speed : {5e-3, 12e-3, 30e-3}) {
      for (double relax : {0.05, 0.15, 0.4}) {
        for (bool upward : {false, true}) all.push_back({law, hand, speed, relax, upward});
      }
    }
  }
  return all;
}

}  // namespace enamel::station::lab
