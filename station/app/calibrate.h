#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "common/scene/calibration.h"
#include "common/scene/delay.h"
#include "common/scene/types.h"
#include "station/devices/calibrator.h"

namespace enamel::station {

struct CalibrateCommand {
  std::filesystem::path data;  // the station's folder, if there is one
  std::string device = "simulated:phantom_desktop";
  std::string profile;  // for comparison; empty: the device's own
  int rate_hz = 1000;
  double max_force_n = 2;     // the most it may use
  std::string name;           // of the proposed profile; empty: the profile's with "-measured"
  std::filesystem::path out;  // the proposed profile
  std::filesystem::path calibration;  // the measurement
  bool yes = false;                   // do not wait for the person's go-ahead
};

// Measures a haptic board, a device of the table of drivers or a simulated one (calibrator.h) and prints the figures beside the
// profile's. Writes a profile made of them (schemas/device_profile.schema.json) and the measurement
// (schemas/calibration.schema.json). For a unit with a serial number the measurement is also kept
// under `data`, where attempts on it find its delay (device_delay.h). Errors: the device's,
// kUnavailable when it cannot be measured, kInvalidInput when no coupling would be stable on it,
// kStorage.
Status CalibrateDevice(const CalibrateCommand& options);

// For each quantity, the worst of three axes.
AxisFigures WorstOf(const std::array<AxisFigures, 3>& axes);

// Keeps a device's answer time in the document.
void NoteAnswers(scene::Calibration& document, const scene::AnswerTime& answers);
// A device whose answers take longer than its pushes showed has that delay now and then.
void RaiseToAnswers(Estimate& delay_ticks, const scene::AnswerTime& answers, int rate_hz);

// A profile with the measured numbers, and the rest of `base`: K = 2 b f/(d + 1)^2, and Kc nine
// tenths of the least of 2 b f/(d + 1)^2, c/S and m (2 pi f1/4)^2 (scene/rate.h) at the lower ends of the
// intervals of b, c and f1. Errors: kInvalidInput when that is less than 1 mN/mm.
Result<scene::DeviceProfile> ProposeProfile(const AxisFigures& worst, int rate_hz,
                                            const scene::DeviceProfile& base,
                                            const std::string& name, const std::string& source);

// The measurement as a document; the caller adds device, profile, station, software and time.
scene::Calibration CalibrationOf(const AxisFigures& worst, int rate_hz);

}  // namespace enamel::station
