#include "station/lab/laws/hand_trial.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "common/fidelity/tracks.h"
#include "common/haptics/uniform_material.h"

namespace enamel::station::lab {
namespace {

// A longer lag is not a delay of the same stroke; a step of 5 ms is a third of what a hand notices
// (fidelity).
constexpr double kLongestLag_s = 1.5, kLagStep_s = 5e-3;
constexpr double kTipSmooth_s = 0.01;

// Follows a way, stiffly or through a spring.
class WayHand final : public Hand {
 public:
  WayHand(const std::vector<dvec3>& way, const dvec3& start, const HandTrial& trial,
          double device_mass_kg)
      : reader_(way), start_(start), trial_(trial) {
    double mass = trial.hand_mass_kg + device_mass_kg;
    // 0.6 of critical damping: 2 * 0.6 sqrt(k m).
    damping_ = 1.2 * std::sqrt(trial.hand_stiffness_n_per_m * mass);
  }
  double mass_kg() const override {
    return trial_.hand == HandKind::kVelocity ? 0 : trial_.hand_mass_kg;
  }
  Grip At(double t_s) override {
    Grip grip;
    grip.equilibrium_m = start_ + reader_.PositionAt(t_s);
    if (trial_.hand == HandKind::kVelocity) {
      grip.prescribed = true;
    } else if (trial_.hand == HandKind::kForce) {
      grip.force_n = reader_.SpeedAt(t_s) * trial_.b_n_s_per_m;
      grip.damping_n_s_per_m = 2;
    } else {
      grip.equilibrium_speed_m_per_s = reader_.SpeedAt(t_s);
      grip.stiffness_n_per_m = trial_.hand_stiffness_n_per_m;
      grip.damping_n_s_per_m = damping_;
    }
    return grip;
  }

 private:
  WayReader reader_;
  dvec3 start_;
  const HandTrial& trial_;
  double damping_;
};

// Figures of sent and ideal force, tick by tick.
struct Track {
  std::vector<dvec3> sent, ideal;
};

double LagOf(const Track& track, double tick_s) {
  double best = -1e300, lag = 0;
  size_t n = track.sent.size(),
         step = std::max<size_t>(1, static_cast<size_t>(kLagStep_s / tick_s));
  for (size_t d = 0; d < n && static_cast<double>(d) * tick_s < kLongestLag_s; d += step) {
    double sum = 0;
    for (size_t k = d; k < n; ++k) sum += Dot(track.sent[k], track.ideal[k - d]);
    sum /= static_cast<double>(n - d);
    if (sum > best) {
      best = sum;
      lag = static_cast<double>(d) * tick_s;
    }
  }
  return lag;
}

struct Means {
  double error2 = 0, oracle2 = 0, ideal2 = 0, trail2 = 0, angle = 0;
  int angles = 0;
};

}  // namespace

HandFigures RunHand(const DeviceModel& m, const HandTrial& trial, const HandMotion& motion) {
  const double tick_s = m.tick_s(), kc = m.kc_n_per_m;
  // Off the middle of a cell on every axis, differently.
  const dvec3 start(3.3e-6, 2.1e-6, 1.1e-6);
  WayHand hand(motion.way_m, start, trial, m.mass_kg);
  WayReader reader(motion.way_m);
  TrialSpec spec = SpecOf(m, trial.law, trial.b_n_s_per_m, 0);
  spec.plant.lattice = trial.lattice;
  spec.plant.delay_ticks = trial.delay_ticks;
  Plant plant(spec.plant, hand, start);
  haptics::CouplingParams params;
  params.law = spec.law;
  params.peak_force_n = spec.peak_force_n;
  params.delay_ticks = trial.delay_ticks;
  if (trial.lattice.joints != glm::dmat3(1) || trial.lattice.driver_cell_m > 0) {
    params.cell = haptics::LatticeCell(m.resolution_m, trial.lattice.driver_cell_m,
                                       trial.lattice.noise_counts);
  }
  haptics::Coupling coupling(params);
  haptics::UniformMaterial material(Sym3::Isotropic(trial.b_n_s_per_m));
  coupling.Reset(plant.Read());

  // Without the last ticks, in which the path and with it the speed ends.
  auto ticks = static_cast<size_t>(reader.duration_s() / tick_s) - 5;
  Track track;
  HandFigures out;
  Means mean;
  dvec3 oracle(0), speed(0), before(0);
  double largest = 0, peak_along = 0, energy = 0;
  for (size_t k = 0; k < ticks; ++k) {
    haptics::CouplingOutput tick = coupling.Tick(plant.Read(), 1, material);
    dvec3 was = plant.tip_m(), r = -tick.force_sent_n;
    plant.Step(tick.force_sent_n);
    dvec3 dx = plant.tip_m() - was;
    // A hand that prescribes its motion has an exact speed. Others have the tip's, smoothed, since
    // a step of the simulation is as rough as the friction that ends it.
    speed = trial.hand == HandKind::kVelocity
                ? reader.SpeedAt(plant.time_s())
                : speed + (plant.speed_m_per_s() - speed) * (tick_s / (kTipSmooth_s + tick_s));
    dvec3 ideal = speed * trial.b_n_s_per_m;
    oracle = fidelity::OracleStep(oracle, ideal, kc * glm::length(speed) * tick_s, m.peak_force_n);
    // The balance of the theorem (common/haptics/README.md), over the true motion.
    energy += Dot(-plant.sent_n(), dx) + m.damping_n_s_per_m / tick_s * Dot(dx, dx) +
              m.friction_n * (std::fabs(dx.x) + std::fabs(dx.y) + std::fabs(dx.z));
    out.energy_min_j = std::min(out.energy_min_j, energy);
    mean.error2 += Dot(r - ideal, r - ideal);
    mean.oracle2 += Dot(oracle - ideal, oracle - ideal);
    mean.ideal2 += Dot(ideal, ideal);
    mean.trail2 += Dot(plant.tip_m() - tick.anchor_m, plant.tip_m() - tick.anchor_m);
    double pace = glm::length(speed), size = glm::length(r);
    if (pace > 0) {
      double along = Dot(r, speed) / pace;
      peak_along = std::max(peak_along, along);
      largest = std::max(largest, glm::length(ideal));
      for (int i = 0; i < 3; ++i)
        out.excess_n = std::max(out.excess_n, speed[i] > 0 ? r[i] - ideal[i] : ideal[i] - r[i]);
      // After a second: a force that is only building up has no meaningful direction.
      if (plant.time_s() > 1 && size > 1e-6) {
        mean.angle += std::acos(std::clamp(along / size, -1.0, 1.0));
        ++mean.angles;
      }
      if (motion.reversal_s > 0 && plant.time_s() > motion.reversal_s && along < -1e-9)
        out.help_s += tick_s;
    }
    double step = glm::length(r - before);
    out.step_n =
        std::max(out.step_n, step - kc * (glm::length(dx) + std::sqrt(3.0) * m.resolution_m));
    before = r;
    track.sent.push_back(r);
    track.ideal.push_back(ideal);
  }
  auto n = static_cast<double>(ticks);
  out.ideal_rms_n = std::sqrt(mean.ideal2 / n);
  out.error_rms_n = std::sqrt(mean.error2 / n);
  out.oracle_rms_n = std::sqrt(mean.oracle2 / n);
  out.trail_m = std::sqrt(mean.trail2 / n);
  out.direction_deg = mean.angles > 0 ? mean.angle / mean.angles * 180 / M_PI : 0;
  out.overshoot = largest > 0 ? std::max(0.0, peak_along / largest - 1) : 0;
  out.lag_s = LagOf(track, tick_s);
  return out;
}

}  // namespace enamel::station::lab
