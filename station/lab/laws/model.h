#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/fidelity/felt.h"
#include "common/scene/types.h"
#include "station/lab/laws/trial.h"

// A device profile in SI units, with the limits its numbers imply.
namespace enamel::station::lab {

struct DeviceModel {
  std::string name, title;
  double resolution_m = 0;
  double max_stiffness_n_per_m = 0;  // K, as published
  double kc_n_per_m = 0;             // what the renderer uses
  double damping_n_s_per_m = 0;      // b
  double friction_n = 0;             // c
  double mass_kg = 0;
  double peak_force_n = 0, continuous_force_n = 0;
  double rate_hz = 1000;
  int delay_ticks = 0;
  double mode_hz = 0;    // lowest structural mode, 0: unknown
  double thermal_s = 0;  // time constant of the motors' heating, 0: unknown
  std::vector<std::pair<std::string, std::string>> provenance;  // number -> where it is from
  scene::DeviceProfile profile;                                 // what it was made from

  fidelity::BoardSpec board;  // ticks above 0: the device's board runs the spring

  double tick_s() const { return 1 / rate_hz; }
  // Ticks of the spring a second, and how many of them pass from reading to force.
  double spring_hz() const { return board.ticks > 0 ? rate_hz * board.ticks : rate_hz; }
  int SpringDelay(int host_ticks) const { return board.ticks > 0 ? board.delay_ticks : host_ticks; }
  // Kc at which the theorem of coupling.h stops holding at this rate: min(2 b / (T (d + 1)^2), 2 c
  // / delta).
  double PassiveKc(double rate_hz) const;
};

// The built-in profiles of devices with motors, as they are shipped, the paper's three first.
std::vector<scene::DeviceProfile> ShippedProfiles();

// Converts and checks. Errors (kInvalidInput, field named): K <= 0, delta <= 0, rate 0, negative b
// or c, Kc above the passive limit at the profile's rate and delay (the message gives the number
// allowed).
Result<DeviceModel> ModelOf(const scene::DeviceProfile& profile);

// A device as an attempt would use it.
struct Unit {
  DeviceModel model;
  bool calibrated = false;
  haptics::OwnFriction told;  // the friction that the law knows
};
// Calibrated: with the profile's delay, and the friction at the lower end of the widest interval that counts. Else
// with the delay that a station assumes of an attached device, and Kc lowered to it. Errors: those of ModelOf;
// kInvalidInput where the delay leaves no coupling.
Result<Unit> UnitOf(const scene::DeviceProfile& shipped, bool calibrated);
// Each device calibrated, then not. A profile whose delay leaves no coupling has no unit.
std::vector<Unit> UnitsOf(const std::vector<DeviceModel>& models);

// The model at another loop rate: same b, c, mass; Kc kept or, with `scale_kc`, raised or lowered
// with 2 b / T as far as friction allows.
DeviceModel AtRate(const DeviceModel& model, double rate_hz, bool scale_kc);

// The model with its spring on the board at `spring_hz`, a multiple of the loop's rate: one inner tick
// of delay, reports a tick of the host late, and the largest Kc that damping and friction pay for with
// cells along the axes.
DeviceModel OnBoard(const DeviceModel& model, double spring_hz);

// The largest Kc that the theorem of common/haptics/README.md carries on this device: what damping pays at
// this rate and delay, and friction for the cell.
double ClauseKc(const DeviceModel& model, const haptics::TipCell& cell, int delay_ticks);
// As the hand trials take it.
fidelity::FeltDevice FeltDeviceOf(const DeviceModel& model);

// Limits of the device in rendering material b at speed v, one sentence each; empty if none.
std::vector<std::string> CannotRender(const DeviceModel& model, double b_n_s_per_m,
                                      double speed_m_per_s);

// A trial of this device with all other parameters at their defaults.
TrialSpec SpecOf(const DeviceModel& model, haptics::LawKind law, double b_n_s_per_m,
                 double speed_m_per_s);

}  // namespace enamel::station::lab
