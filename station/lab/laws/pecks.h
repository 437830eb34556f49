#pragma once

#include <vector>

#include "station/lab/laws/model.h"

// Dentists touch a tooth for a quarter of a second and lift off again. How deep a bur goes in that time on a device,
// against an ideal tool in the same hand. SI units.
// Deterministic. Thread safety: functions, any thread.
namespace enamel::station::lab {

// From rest on the surface of fresh tissue. A hand of kPeckGrip_n_per_m wants to go as far in as would press with
// `press_n` on what does not give; in and out on a raised cosine of kPeckRise_s.
struct Peck {
  double press_n = 0.7, contact_s = 0.3;
  double b_n_s_per_m = 890;
};
inline constexpr double kPeckRise_s = 0.05, kPeckGrip_n_per_m = 1000;
// 35 to 105 g for 0.2 to 0.6 s, in what the exercises' burs meet.
std::vector<Peck> AllPecks();

struct PeckFigures {
  double depth_m = 0, tool_depth_m = 0;  // of the bur, when the hand has let go
  // Force in the hand while it touches: RMS of the error, and of the tool's force.
  double felt_error_rms_n = 0, tool_rms_n = 0;
};
PeckFigures RunPeck(const DeviceModel& model, const haptics::OwnFriction& told, const Peck& peck);

}  // namespace enamel::station::lab
