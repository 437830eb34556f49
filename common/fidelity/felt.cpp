#include "common/fidelity/felt.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "common/fidelity/way.h"
#include "common/haptics/coupling.h"
#include "common/haptics/uniform_material.h"

namespace enamel::fidelity {
namespace {

// Above this a force is felt as vibration, and no longer follows the hand.
constexpr double kRipple_hz = 15;
// Shorter steps than T/8 change no figure here; a fast loop's tick is short already.
constexpr int kSubsteps = 8;

// Holds a way, or pushes.
class WayHand final : public Hand {
 public:
  WayHand(const std::vector<dvec3>& way, const dvec3& start, const HandOn& on, double device_kg)
      : reader_(way), start_(start), on_(on) {
    const double k = on.stiffness_n_per_m.value_or(0);
    damping_ = on.damping_n_s_per_m.value_or(1.2 * std::sqrt(k * (on.mass_kg + device_kg)));
  }
  double mass_kg() const override { return on_.stiffness_n_per_m ? on_.mass_kg : 0; }
  // Of the grip on this plant now.
  dvec3 Force(const Plant& plant) {
    const Grip grip = At(plant.time_s());
    return grip.force_n + (grip.equilibrium_m - plant.tip_m()) * grip.stiffness_n_per_m +
           (grip.equilibrium_speed_m_per_s - plant.speed_m_per_s()) * grip.damping_n_s_per_m;
  }
  Grip At(double t_s) override {
    Grip grip;
    if (!on_.stiffness_n_per_m) {
      grip.prescribed = true;
      grip.equilibrium_m = start_ + reader_.PositionAt(t_s);
      return grip;
    }
    grip.force_n = on_.push_n;
    grip.damping_n_s_per_m = damping_;
    grip.stiffness_n_per_m = *on_.stiffness_n_per_m;
    if (grip.stiffness_n_per_m > 0) {
      grip.equilibrium_m = start_ + reader_.PositionAt(t_s);
      grip.equilibrium_speed_m_per_s = reader_.SpeedAt(t_s);
    }
    return grip;
  }

 private:
  WayReader reader_;
  dvec3 start_;
  HandOn on_;
  double damping_ = 0;
};

PlantSpec SpecOf(const FeltDevice& d, const FeltTrial& trial) {
  PlantSpec s;
  s.mass_kg = d.mass_kg;
  s.damping_n_s_per_m = d.damping_n_s_per_m;
  s.friction_n = d.friction_n;
  s.resolution_m = d.resolution_m;
  s.lattice = trial.lattice;
  s.tick_s = d.inner_tick_s();
  s.peak_force_n = d.peak_force_n;
  s.delay_ticks = d.board.ticks > 0 ? d.board.delay_ticks : trial.delay_ticks;
  s.substeps = s.tick_s > 0.5e-3 ? kSubsteps : 4;
  return s;
}

haptics::CouplingParams CouplingOf(const FeltDevice& d, const FeltTrial& trial) {
  haptics::CouplingParams p;
  p.law = {trial.law, d.kc_n_per_m, dvec3(d.resolution_m), d.tick_s};
  p.peak_force_n = d.peak_force_n;
  p.delay_ticks = trial.delay_ticks;
  p.cell = CellOf(trial.lattice, d.resolution_m);
  return p;
}

// The law and its spring, wherever that runs.
class Renderer {
 public:
  Renderer(const FeltDevice& d, const FeltTrial& trial)
      : material_(trial.b_n_s_per_m), coupling_(CouplingOf(d, trial)) {
    if (d.board.ticks > 0) board_.emplace(CouplingOf(d, trial), d.board, d.damping_n_s_per_m);
  }
  void Reset(const dvec3& reading) {
    coupling_.Reset(reading);
    if (board_) board_->Reset(reading);
  }
  // On the operator.
  dvec3 Tick(const dvec3& reading) {
    if (board_) return board_->Tick(reading, material_);
    return coupling_.Tick(reading, 1, material_).force_sent_n;
  }

 private:
  haptics::UniformMaterial material_;
  haptics::Coupling coupling_;
  std::optional<BoardLoop> board_;
};

// The balance of the theorem (common/haptics/README.md), over the true motion.
class Balance {
 public:
  // `off_m`: of the reading where the spring begins at rest; what is in it then is the floor.
  Balance(const FeltDevice& d, const dvec3& off_m)
      : b_over_t_(d.damping_n_s_per_m / d.inner_tick_s()),
        friction_(d.friction_n),
        sum_(0.5 * d.kc_n_per_m * Dot(off_m, off_m)) {}
  void Add(const dvec3& resisted_n, const dvec3& moved) {
    sum_ += Dot(resisted_n, moved) + b_over_t_ * Dot(moved, moved) +
            friction_ * (std::fabs(moved.x) + std::fabs(moved.y) + std::fabs(moved.z));
    least_ = std::min(least_, sum_);
  }
  double least_j() const { return least_; }

 private:
  double b_over_t_, friction_, sum_, least_ = 0;
};

}  // namespace

haptics::TipCell CellOf(const Lattice& lattice, double resolution_m) {
  if (lattice.joints == glm::dmat3(1) && lattice.driver_cell_m == 0)
    return haptics::CartesianCell(dvec3(resolution_m), lattice.noise_counts);
  return haptics::LatticeCell(resolution_m, lattice.driver_cell_m, lattice.noise_counts);
}

FeltFigures Feel(const FeltDevice& d, const FeltTrial& trial, const std::vector<dvec3>& way) {
  // Off the middle of a cell on every axis, differently.
  const dvec3 start(3.3e-6, 2.1e-6, 1.1e-6);
  const PlantSpec spec = SpecOf(d, trial);
  PlantSpec reference = spec;
  if (trial.friction_counts) reference.friction_n = 0;
  WayHand hand(way, start, trial.hand, d.mass_kg), same(way, start, trial.hand, d.mass_kg);
  Plant plant(spec, hand, start), damped(reference, same, start);
  Renderer renderer(d, trial);
  renderer.Reset(plant.Read());

  // Without the last ticks, in which the path and with it the speed ends.
  const auto ticks = static_cast<size_t>(WayReader(way).duration_s() / spec.tick_s) - 5;
  const auto from = static_cast<size_t>(trial.from_s / spec.tick_s);
  const double low_pass = 2 * M_PI * kRipple_hz * spec.tick_s;
  Balance balance(d, plant.Read() - start);
  FeltFigures out;
  dvec3 smooth(0);
  std::vector<dvec3> judged;
  double error2 = 0, ideal2 = 0, ripple2 = 0;
  for (size_t k = 0; k < ticks; ++k) {
    const dvec3 r = -renderer.Tick(plant.Read()), was = plant.tip_m();
    plant.Step(-r);
    balance.Add(-plant.sent_n(), plant.tip_m() - was);
    dvec3 ideal = trial.ideal ? damped.StepDamped(trial.b_n_s_per_m, d.peak_force_n) : dvec3(0);
    const dvec3 off = trial.friction_counts ? hand.Force(plant) - same.Force(damped) : r - ideal;
    if (trial.friction_counts) ideal = same.Force(damped);
    smooth += (r - smooth) * (low_pass / (1 + low_pass));
    if (k < from) continue;
    judged.push_back(r);
    error2 += Dot(off, off);
    ideal2 += Dot(ideal, ideal);
    ripple2 += Dot(r - smooth, r - smooth);
    out.mean_n += r;
  }
  const auto n = static_cast<double>(judged.size());
  if (trial.ideal) {
    out.error_rms_n = std::sqrt(error2 / n);
    out.ideal_rms_n = std::sqrt(ideal2 / n);
  }
  out.ripple_n = std::sqrt(ripple2 / n);
  out.mean_n /= n;
  const double length = glm::length(out.mean_n);
  const dvec3 along = length > 0 ? out.mean_n / length : dvec3(1, 0, 0);
  out.least_n = 1e300;
  out.most_n = -1e300;
  for (const dvec3& r : judged) {
    out.least_n = std::min(out.least_n, Dot(r, along));
    out.most_n = std::max(out.most_n, Dot(r, along));
  }
  out.energy_min_j = balance.least_j();
  return out;
}

double ClosedFormError(double kh, double k, double b, double omega) {
  const std::complex<double> s(0, omega);
  const double kt = kh * k / (kh + k);
  return std::abs((kt / (s + kt / b)) / (kh / (s + kh / b)) - 1.0);
}

}  // namespace enamel::fidelity
