#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/base/result.h"

// Measurements of one haptic device (schemas/calibration.schema.json): written by `enamel-station
// calibrate`, kept by the server beside the device profile it is compared with. Thread safety:
// functions, any thread. Real-time: not safe.
namespace enamel::scene {

struct Measured {
  int64_t value = 0;
  int64_t uncertainty = 0;  // half the width of the 95 % interval, in the unit of the value
  int64_t samples = 1;      // independent readings it is from

  bool operator==(const Measured&) const = default;
};

// Each quantity is that of the worst axis; none: not measured. At least one is.
struct Calibration {
  std::string device;       // how the station addresses it, with its serial number if it has one
  std::string profile;      // name of the device profile it is compared with
  std::string station;      // its name; empty when it has none yet
  std::string software;     // that measured
  int64_t measured_ms = 0;  // since the Unix epoch, UTC
  int64_t rate_hz = 1000;
  std::string method;                          // so that somebody can do it again
  std::optional<Measured> resolution_nm;       // delta
  std::optional<Measured> noise_nm;            // standard deviation at rest
  std::optional<Measured> friction_mn;         // c, Coulomb
  std::optional<Measured> damping_mn_s_per_m;  // b, viscous
  std::optional<Measured> mass_g;              // effective, at the tip
  std::optional<Measured> bus_delay_ticks;     // whole ticks between pose and force
  std::optional<Measured> answer_us;           // median, of a device that answers to forces
  std::optional<Measured> answer_jitter_us;    // to the 99th of 100 answers
  std::optional<Measured> structural_mode_hz;  // f1, the lowest resonance; none: none was found

  bool operator==(const Calibration&) const = default;
};

// Canonical text (common/scene/json/json.h). Requires: at least one quantity.
std::string ToJson(const Calibration& calibration);
// Strict and bounded as common/scene/json/json.h says. Errors: kInvalidInput with the member's path
// in field(), kVersion, kTooLarge.
Result<Calibration> CalibrationFromJson(std::string_view json);

}  // namespace enamel::scene
