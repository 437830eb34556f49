#include "station/lab/laws/pecks.h"

#include <cmath>

#include "common/fidelity/felt.h"
#include "common/fidelity/plant.h"
#include "station/lab/laws/half_space.h"

namespace enamel::station::lab {
namespace {

constexpr double kHand_kg = 0.1, kBack_m = 0.3e-3, kAway_s = 0.1;

// Off the middle of a cell on every axis, differently.
const dvec3 kStart_m(3.3e-6, 2.1e-6, 1.1e-6);

class PeckingHand final : public fidelity::Hand {
 public:
  PeckingHand(const Peck& peck, double device_kg)
      : peck_(peck),
        damping_n_s_per_m_(1.2 * std::sqrt(kPeckGrip_n_per_m * (kHand_kg + device_kg))) {}
  double mass_kg() const override { return kHand_kg; }
  fidelity::Grip At(double t_s) override {
    fidelity::Grip grip;
    constexpr double kStep_s = 1e-5;
    grip.stiffness_n_per_m = kPeckGrip_n_per_m;
    grip.damping_n_s_per_m = damping_n_s_per_m_;
    grip.equilibrium_m = PlaceAt(t_s);
    grip.equilibrium_speed_m_per_s = (PlaceAt(t_s + kStep_s) - grip.equilibrium_m) / kStep_s;
    return grip;
  }
  bool touches(double t_s) const { return t_s < peck_.contact_s; }
  dvec3 PlaceAt(double t_s) const {
    const double edge = std::min({t_s, peck_.contact_s - t_s, kPeckRise_s}) / kPeckRise_s;
    const double in_m = peck_.press_n / kPeckGrip_n_per_m;
    return kStart_m + HalfSpace::kInward *
                          (edge > 0 ? in_m * 0.5 * (1 - std::cos(M_PI * edge))
                                    : std::max(-kBack_m, edge * kPeckRise_s / kAway_s * kBack_m));
  }

 private:
  const Peck& peck_;
  const double damping_n_s_per_m_;
};

// The force in the hand in each tick of the touch, and how far the bur went.
struct Run {
  std::vector<dvec3> in_hand_n;
  double depth_m = 0;
};

fidelity::PlantSpec PlantOf(const DeviceModel& m) {
  fidelity::PlantSpec s = SpecOf(m, haptics::kDefaultLaw, 0, 0).plant;
  s.mode_hz = 0;  // rigid
  return s;
}

Run OnDevice(const DeviceModel& m, const haptics::OwnFriction& told, const Peck& peck) {
  haptics::CouplingParams params;
  params.law = SpecOf(m, haptics::kDefaultLaw, peck.b_n_s_per_m, 0).law;
  params.peak_force_n = m.peak_force_n;
  params.delay_ticks = m.delay_ticks;
  params.friction = told;
  haptics::Coupling coupling(params);
  PeckingHand hand(peck, m.mass_kg);
  fidelity::Plant plant(PlantOf(m), hand, kStart_m);
  coupling.Reset(plant.Read());
  const double surface_m = Dot(plant.Read(), HalfSpace::kInward);
  HalfSpace tissue(peck.b_n_s_per_m, surface_m);
  Run out;
  while (plant.time_s() < peck.contact_s + kAway_s) {
    const bool touches = hand.touches(plant.time_s());
    plant.Step(coupling.Tick(plant.Read(), 1, tissue).force_sent_n);
    if (touches) out.in_hand_n.push_back(plant.in_hand_n());
  }
  out.depth_m = tissue.surface_m() - surface_m;
  return out;
}

// The ideal: a bur at the tip, and nothing else.
Run OnTool(const DeviceModel& m, const Peck& peck) {
  fidelity::PlantSpec spec = PlantOf(m);
  spec.mass_kg = spec.damping_n_s_per_m = spec.friction_n = 0;
  PeckingHand hand(peck, m.mass_kg);
  fidelity::Plant plant(spec, hand, kStart_m);
  Run out;
  while (hand.touches(plant.time_s())) {
    // Nothing holds a hand that goes back.
    const dvec3 ahead = hand.PlaceAt(plant.time_s()) - plant.tip_m();
    const bool cuts = Dot(ahead, HalfSpace::kInward) > 0;
    plant.StepDamped(Sym3::Isotropic(cuts ? peck.b_n_s_per_m : 0), 1e9);
    out.in_hand_n.push_back(plant.in_hand_n());
    out.depth_m = std::max(out.depth_m, Dot(plant.tip_m() - kStart_m, HalfSpace::kInward));
  }
  return out;
}

}  // namespace

std::vector<Peck> AllPecks() {
  std::vector<Peck> out;
  for (const double b : {3560.0, 890.0, 100.0})
    for (const double press_n : {0.35, 0.7, 1.0})
      for (const double contact_s : {0.2, 0.4, 0.6}) out.push_back({press_n, contact_s, b});
  return out;
}

PeckFigures RunPeck(const DeviceModel& m, const haptics::OwnFriction& told, const Peck& peck) {
  const Run device = OnDevice(m, told, peck), tool = OnTool(m, peck);
  PeckFigures out;
  out.depth_m = device.depth_m;
  out.tool_depth_m = tool.depth_m;
  double error2 = 0, tool2 = 0;
  const size_t n = std::min(device.in_hand_n.size(), tool.in_hand_n.size());
  for (size_t i = 0; i < n; ++i) {
    const dvec3 off = device.in_hand_n[i] - tool.in_hand_n[i];
    error2 += Dot(off, off);
    tool2 += Dot(tool.in_hand_n[i], tool.in_hand_n[i]);
  }
  out.felt_error_rms_n = std::sqrt(error2 / static_cast<double>(n));
  out.tool_rms_n = std::sqrt(tool2 / static_cast<double>(n));
  return out;
}

}  // namespace enamel::station::lab
