#include "common/fidelity/felt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>

#include "common/fidelity/series.h"
#include "common/fidelity/way.h"
#include "common/haptics/coupling.h"
#include "common/haptics/uniform_material.h"

namespace enamel::fidelity {
namespace {

// Above this a force is felt as vibration, and no longer follows the hand.
constexpr double kRipple_hz = 15;

// The part of a signal above it, by two stages of first order: one alone would let a fifteenth of a motion at
// 1 Hz through.
class AboveRipple {
 public:
  explicit AboveRipple(double tick_s) {
    const double low_pass = 2 * M_PI * kRipple_hz * tick_s;
    share_ = low_pass / (1 + low_pass);
  }
  dvec3 Add(dvec3 value) {
    for (dvec3& smooth : smooth_) {
      smooth += (value - smooth) * share_;
      value -= smooth;
    }
    return value;
  }

 private:
  double share_;
  std::array<dvec3, 2> smooth_{dvec3(0), dvec3(0)};
};
// Shorter steps than T/8 change no figure here; a fast loop's tick is short already.
constexpr int kSubsteps = 8;

// Holds a way, or pushes.
class WayHand final : public Hand {
 public:
  WayHand(const std::vector<dvec3>& way, const dvec3& start, const HandOn& on, double device_kg)
      : reader_(way), start_(start), on_(SameHand(on, device_kg)) {}
  double mass_kg() const override { return on_.stiffness_n_per_m ? on_.mass_kg : 0; }
  Grip At(double t_s) override {
    Grip grip;
    if (!on_.stiffness_n_per_m) {
      grip.prescribed = true;
      grip.equilibrium_m = start_ + reader_.PositionAt(t_s);
      return grip;
    }
    grip.force_n = on_.push_n;
    grip.damping_n_s_per_m = *on_.damping_n_s_per_m;
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
  p.law.estimator = trial.estimator;
  p.peak_force_n = d.peak_force_n;
  p.delay_ticks = trial.delay_ticks;
  p.cell = CellOf(trial.lattice, d.resolution_m);
  p.friction = trial.friction;
  return p;
}

// The law and its spring, wherever that runs.
class Renderer {
 public:
  Renderer(const FeltDevice& d, const FeltTrial& trial)
      : material_(trial.load ? haptics::UniformMaterial(*trial.load)
                             : haptics::UniformMaterial(trial.b_n_s_per_m)),
        coupling_(CouplingOf(d, trial)) {
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

// Off the middle of a cell on every axis, differently.
const dvec3 kStart_m(3.3e-6, 2.1e-6, 1.1e-6);

// Without the last ticks, in which the path and with it the speed ends.
size_t TicksOf(const std::vector<dvec3>& way, const PlantSpec& spec) {
  return static_cast<size_t>(WayReader(way).duration_s() / spec.tick_s) - 5;
}

// Ripple, mean, and the ends of the force along its mean.
void JudgeForce(const std::vector<dvec3>& r, size_t from, double tick_s, FeltFigures* out) {
  AboveRipple above(tick_s);
  double ripple2 = 0;
  for (size_t i = 0; i < r.size(); ++i) {
    const dvec3 ripple = above.Add(r[i]);
    if (i < from) continue;
    ripple2 += Dot(ripple, ripple);
    out->mean_n += r[i];
  }
  const auto n = static_cast<double>(r.size() - from);
  out->ripple_n = std::sqrt(ripple2 / n);
  out->mean_n /= n;
  const double length = glm::length(out->mean_n);
  const dvec3 along = length > 0 ? out->mean_n / length : dvec3(1, 0, 0);
  out->least_n = 1e300;
  out->most_n = -1e300;
  for (size_t i = from; i < r.size(); ++i) {
    out->least_n = std::min(out->least_n, Dot(r[i], along));
    out->most_n = std::max(out->most_n, Dot(r[i], along));
  }
}

void JudgeHand(const Series& in_hand, const Series& tool, double tick_s, FeltFigures* out) {
  const Series off = Difference(in_hand, tool);
  const size_t n = off.size(), second = static_cast<size_t>(1 / tick_s + 0.5);
  out->felt_error_rms_n = RmsOf(off);
  out->felt_error_p95_n = WithinOf(off, 0.95);
  out->tool_rms_n = RmsOf(tool);
  for (size_t i = 0; i + second <= n; i += second)
    out->seconds.push_back({RmsOf(tool, i, i + second), RmsOf(off, i, i + second)});
}

}  // namespace

haptics::TipCell CellOf(const Lattice& lattice, double resolution_m) {
  if (lattice.joints == glm::dmat3(1) && lattice.driver_cell_m == 0)
    return haptics::CartesianCell(dvec3(resolution_m), lattice.noise_counts);
  return haptics::LatticeCell(resolution_m, lattice.driver_cell_m, lattice.noise_counts);
}

HandOn SameHand(HandOn hand, double device_kg) {
  if (!hand.damping_n_s_per_m)
    hand.damping_n_s_per_m =
        1.2 * std::sqrt(hand.stiffness_n_per_m.value_or(0) * (hand.mass_kg + device_kg));
  return hand;
}

FeltDevice ToolOf(const FeltDevice& device) {
  FeltDevice tool = device;
  tool.mass_kg = tool.damping_n_s_per_m = tool.friction_n = 0;
  tool.peak_force_n = std::numeric_limits<double>::max();
  return tool;
}

std::vector<dvec3> ForceInHand(const FeltDevice& d, const FeltTrial& trial,
                               const std::vector<dvec3>& way, bool damper) {
  const PlantSpec spec = SpecOf(d, trial);
  WayHand hand(way, kStart_m, trial.hand, d.mass_kg);
  Plant plant(spec, hand, kStart_m);
  std::optional<Renderer> renderer;
  if (!damper) {
    renderer.emplace(d, trial);
    renderer->Reset(plant.Read());
  }
  std::vector<dvec3> out;
  for (size_t k = 0, ticks = TicksOf(way, spec); k < ticks; ++k) {
    if (damper)
      plant.StepDamped(trial.b_n_s_per_m, d.peak_force_n);
    else
      plant.Step(renderer->Tick(plant.Read()));
    out.push_back(plant.in_hand_n());
  }
  return out;
}

FeltFigures Feel(const FeltDevice& d, const FeltTrial& trial, const std::vector<dvec3>& way) {
  const PlantSpec spec = SpecOf(d, trial);
  WayHand hand(way, kStart_m, trial.hand, d.mass_kg), same(way, kStart_m, trial.hand, d.mass_kg);
  Plant plant(spec, hand, kStart_m), damped(spec, same, kStart_m);
  Renderer renderer(d, trial);
  renderer.Reset(plant.Read());

  const auto from = static_cast<size_t>(trial.from_s / spec.tick_s);
  Balance balance(d, plant.Read() - kStart_m);
  Series sent, ideal, in_hand;  // but for `sent` only what is judged
  for (size_t k = 0, ticks = TicksOf(way, spec); k < ticks; ++k) {
    const dvec3 r = -renderer.Tick(plant.Read()), was = plant.tip_m();
    plant.Step(-r);
    balance.Add(-plant.sent_n(), plant.tip_m() - was);
    if (trial.ideal) {
      const dvec3 right = damped.StepDamped(trial.b_n_s_per_m, d.peak_force_n);
      if (k >= from) ideal.push_back(right);
    }
    sent.push_back(r);
    if (trial.tool && k >= from) in_hand.push_back(plant.in_hand_n());
  }
  FeltFigures out;
  out.energy_min_j = balance.least_j();
  JudgeForce(sent, from, spec.tick_s, &out);
  if (trial.ideal) {
    sent.erase(sent.begin(), sent.begin() + static_cast<long>(from));
    out.error_rms_n = RmsOf(Difference(sent, ideal));
    out.ideal_rms_n = RmsOf(ideal);
  }
  if (trial.tool) {
    FeltTrial same_hand = trial;
    same_hand.hand = SameHand(trial.hand, d.mass_kg);
    Series tool = ForceInHand(ToolOf(d), same_hand, way, true);
    tool.erase(tool.begin(), tool.begin() + static_cast<long>(from));
    JudgeHand(in_hand, tool, spec.tick_s, &out);
  }
  return out;
}

double ClosedFormError(double kh, double k, double b, double omega) {
  const std::complex<double> s(0, omega);
  const double kt = kh * k / (kh + k);
  return std::abs((kt / (s + kt / b)) / (kh / (s + kh / b)) - 1.0);
}

}  // namespace enamel::fidelity
