#include "station/lab/laws/swings.h"

#include <algorithm>
#include <cmath>

#include "common/fidelity/felt.h"
#include "common/fidelity/way.h"

namespace enamel::station::lab {
namespace {

constexpr double kSwing_n = 1, kLasts_s = 0.5, kWindow_s = 0.1;
constexpr double kAbove_m = 0.33e-3;
constexpr double kPushRises_s = 0.25;

// Tissue or a wall below z = 0, or tissue everywhere.
class Ground final : public haptics::Material {
 public:
  Ground(double b_n_s_per_m, bool surface, bool wall)
      : b_(Sym3::Isotropic(b_n_s_per_m)), surface_(surface), wall_(wall) {}

  haptics::Contact ContactAt(const dvec3& bur, const dvec3& stretch) noexcept override {
    haptics::Contact out;
    const bool down = stretch.z < 0;
    if (surface_ && bur.z > 0) {
      // Just into the surface, or all of the way.
      const double way = glm::length(stretch);
      const bool reaches = down && bur.z + stretch.z < 0;
      out.clearance_m = reaches ? way * bur.z / -stretch.z + 1e-8 : way;
      return out;
    }
    if (surface_ && !down) return out;
    out.engaged = true;
    if (wall_)
      out.wall_normal = dvec3(0, 0, -1);
    else
      out.damping_n_s_per_m = b_;
    if (!surface_) out.clearance_m = 1;
    return out;
  }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}

 private:
  const Sym3 b_;
  const bool surface_, wall_;
};

bool OnSurface(const SwingTrial& t) {
  return t.hand == SwingHand::kLand || t.hand == SwingHand::kTap;
}
bool Pushes(const SwingTrial& t) {
  return t.hand == SwingHand::kPush || t.hand == SwingHand::kLand;
}

class SwingingHand final : public Hand {
 public:
  explicit SwingingHand(const SwingTrial& trial) : trial_(trial) {
    if (!trial.way_m.empty()) way_.emplace(trial.way_m);
  }
  double mass_kg() const override { return trial_.mass_kg; }
  Grip At(double t_s) override {
    Grip grip;
    grip.damping_n_s_per_m = trial_.damping_n_s_per_m;
    if (Pushes(trial_)) {
      grip.force_n = trial_.direction * (trial_.push_n * std::min(1.0, t_s / kPushRises_s));
      return grip;
    }
    grip.stiffness_n_per_m = trial_.stiffness_n_per_m;
    grip.equilibrium_m = PlaceAt(t_s);
    constexpr double kStep_s = 1e-5;
    grip.equilibrium_speed_m_per_s = (PlaceAt(t_s + kStep_s) - grip.equilibrium_m) / kStep_s;
    return grip;
  }
  dvec3 PlaceAt(double t_s) const {
    if (way_) return way_->PositionAt(t_s);
    const double stroke = 2 * M_PI * trial_.stroke_hz * t_s;
    const double tremor = trial_.tremor_m * std::sin(2 * M_PI * trial_.tremor_hz * t_s + 0.4);
    dvec3 out = dvec3(1, 0.6, -0.8) * tremor;
    if (trial_.hand == SwingHand::kTap)
      out.z += kAbove_m + trial_.stroke_m * 0.5 * (std::cos(stroke) - 1);
    else
      out += trial_.direction * (trial_.stroke_m * std::sin(stroke));
    return out;
  }

 private:
  const SwingTrial& trial_;
  std::optional<fidelity::WayReader> way_;
};

// Peak to peak in windows that end at each tick, less the mean around.
std::vector<double> PeakToPeak(const std::vector<dvec3>& force, double tick_s) {
  const auto n = force.size(), window = static_cast<size_t>(kWindow_s / tick_s + 0.5);
  std::vector<dvec3> sum(n + 1, dvec3(0)), off(n);
  for (size_t i = 0; i < n; ++i) sum[i + 1] = sum[i] + force[i];
  for (size_t i = 0; i < n; ++i) {
    const size_t from = i < window / 2 ? 0 : i - window / 2, to = std::min(n, i + window / 2);
    off[i] = force[i] - (sum[to] - sum[from]) / static_cast<double>(to - from);
  }
  std::vector<double> out(n, 0);
  for (size_t i = window; i < n; ++i) {
    dvec3 least = off[i], most = off[i];
    for (size_t k = i - window; k < i; ++k) {
      least = glm::min(least, off[k]);
      most = glm::max(most, off[k]);
    }
    out[i] = glm::length(most - least);
  }
  return out;
}

}  // namespace

const std::vector<ProfileError>& ProfileErrors() {
  static const std::vector<ProfileError> kErrors = {
      {"none"},
      {.name = "b/2", .damping = 0.5},
      {.name = "b/4", .damping = 0.25},
      {.name = "b/7", .damping = 1 / 7.0},
      {.name = "c/2", .friction = 0.5},
      {.name = "c x2", .friction = 2},
      {.name = "b/4 c/2", .damping = 0.25, .friction = 0.5},
      {.name = "b/7 c/3", .damping = 1 / 7.0, .friction = 1 / 3.0},
      {.name = "mass x2", .mass = 2},
      {.name = "one tick", .ticks = 1},
      {.name = "two ticks", .ticks = 2},
      {.name = "b/3, one tick", .damping = 1 / 3.0, .ticks = 1},
      {.name = "b/4 c/2, one tick", .damping = 0.25, .friction = 0.5, .ticks = 1},
  };
  return kErrors;
}

const char* NameOf(SwingHand hand) {
  constexpr const char* kNames[] = {"push", "land", "grip", "tap"};
  return kNames[static_cast<int>(hand)];
}

SwingTrial DrawSwingTrial(SwingHand hand, const DeviceModel& m, bool light, Random& random) {
  SwingTrial t;
  t.hand = hand;
  t.mass_kg = random.LogBetween(0.03, 0.6);
  t.direction = random.Direction();
  t.wall = random.Uniform() < 0.4;
  t.b_n_s_per_m = random.LogBetween(130, 9000);
  if (Pushes(t)) {
    t.damping_n_s_per_m = random.LogBetween(0.25, light ? 1.6 : 8);
    t.push_n = std::min(random.LogBetween(0.15, 6), 0.8 * m.peak_force_n);
    if (hand == SwingHand::kPush) t.push_n = std::min(t.push_n, t.b_n_s_per_m * 0.015);
    if (hand == SwingHand::kLand)
      t.direction = glm::normalize(dvec3(0.4 * random.Signed(), 0.4 * random.Signed(), -1));
  } else {
    t.stiffness_n_per_m = random.LogBetween(150, 4000);
    const double ratio = light ? random.LogBetween(0.012, 0.08) : random.LogBetween(0.04, 0.7);
    t.damping_n_s_per_m = 2 * ratio * std::sqrt(t.stiffness_n_per_m * (t.mass_kg + m.mass_kg));
    const bool tap = hand == SwingHand::kTap;
    t.stroke_m = tap ? random.LogBetween(0.7e-3, 2.5e-3) : random.LogBetween(0.1e-3, 1.7e-3);
    t.stroke_hz = random.LogBetween(0.3, tap ? 6 : 3);
    // Physiological tremor of a held tool: 8 to 12 Hz, tens of micrometres.
    t.tremor_m = random.LogBetween(2e-6, 50e-6);
    t.tremor_hz = random.Between(8, 12);
  }
  // Turned encoders, where the profile's friction pays for them.
  const haptics::TipCell turned = haptics::LatticeCell(m.resolution_m, 0, 0);
  if (random.Uniform() < 0.5 && m.kc_n_per_m <= ClauseKc(m, turned, m.delay_ticks)) {
    const dvec3 x = random.Direction(), z = glm::normalize(glm::cross(x, random.Direction()));
    t.lattice.joints = glm::dmat3(x, glm::cross(z, x), z);
  }
  return t;
}

std::vector<dvec3> RunSwingTrial(const DeviceModel& m, const SwingTrial& trial,
                                 const ProfileError& error, bool watched) {
  TrialSpec spec = SpecOf(m, haptics::kDefaultLaw, trial.b_n_s_per_m, 0);
  spec.plant.damping_n_s_per_m *= error.damping;
  spec.plant.friction_n *= error.friction;
  spec.plant.mass_kg *= error.mass;
  spec.plant.delay_ticks += error.ticks;
  spec.plant.peak_force_n = m.peak_force_n;
  spec.plant.lattice = trial.lattice;
  haptics::CouplingParams params;
  params.law = spec.law;
  params.peak_force_n = m.peak_force_n;
  params.delay_ticks = m.delay_ticks;
  params.cell = fidelity::CellOf(trial.lattice, m.resolution_m);
  params.friction = trial.told;
  params.watch_swings = watched;
  haptics::Coupling coupling(params);
  SwingingHand hand(trial);
  Ground ground(trial.b_n_s_per_m, OnSurface(trial), OnSurface(trial) && trial.wall);
  dvec3 start(3.3e-6, 2.1e-6, 1.1e-6);
  if (trial.hand == SwingHand::kLand) start.z += kAbove_m;
  if (!Pushes(trial)) start += hand.PlaceAt(0);
  Plant plant(spec.plant, hand, start);
  coupling.Reset(plant.Read());
  std::vector<dvec3> out;
  for (int i = 0, n = static_cast<int>(trial.seconds / m.tick_s()); i < n; ++i) {
    const haptics::CouplingOutput tick = coupling.Tick(plant.Read(), 1, ground);
    plant.Step(tick.force_sent_n);
    out.push_back(tick.force_sent_n - tick.push_n);
  }
  return out;
}

std::optional<double> SwingBegins(const std::vector<dvec3>& force, double tick_s) {
  const std::vector<double> swing = PeakToPeak(force, tick_s);
  const auto lasts = static_cast<size_t>(kLasts_s / tick_s + 0.5);
  size_t above = 0;
  for (size_t i = 0; i < swing.size(); ++i) {
    above = swing[i] > kSwing_n ? above + 1 : 0;
    if (above > lasts) return static_cast<double>(i - lasts) * tick_s;
  }
  return std::nullopt;
}

double SwingLeft(const std::vector<dvec3>& force, double tick_s) {
  const std::vector<double> swing = PeakToPeak(force, tick_s);
  const auto last = std::min(swing.size(), static_cast<size_t>(1 / tick_s + 0.5));
  return swing.empty() ? 0 : *std::max_element(swing.end() - static_cast<long>(last), swing.end());
}

std::optional<double> SwingSeen(const std::vector<dvec3>& force,
                                const haptics::SwingWatchParams& params) {
  haptics::SwingWatch watch(params);
  for (size_t i = 0; i < force.size(); ++i) {
    watch.Tick(force[i]);
    if (watch.tripped()) return static_cast<double>(i) * params.tick_s;
  }
  return std::nullopt;
}

}  // namespace enamel::station::lab
