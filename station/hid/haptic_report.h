#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/base/bytes.h"
#include "common/board/report.h"
#include "station/devices/device.h"

// The reports of a haptic board as bytes: schemas/hid_haptic_report.md. The station's half is here; the
// board's half is the reference firmware's (common/board/report.h), for emulators and tests. Pure
// functions, any thread. Real-time: decoding input and encoding output are safe.
namespace enamel::station::hid {

inline constexpr uint8_t kInputId = kEnPoseId, kOutputId = kEnForceId, kSpringId = kEnSpringId,
                         kFeatureId = 0x44;
inline constexpr uint8_t kReportVersion = kEnReportVersion;
inline constexpr size_t kInputBytes = kEnPoseBytes, kOutputBytes = kEnForceBytes,
                        kSpringBytes = kEnSpringBytes, kFeatureBytes = 106;
inline constexpr uint16_t kBoardUsagePage = 0xFF45, kBoardUsage = 0x0001;

enum BoardStatus : uint8_t {
  kMotorsOn = 1 << 0,
  kWatchdogTripped = 1 << 1,
  kNotFit = 1 << 2,
  kOrientationValid = 1 << 3,
};

// EnPoseReport.
struct InputReport {
  uint8_t status = 0;  // BoardStatus
  uint8_t buttons = 0;
  uint32_t sequence = 0;
  uint32_t time_us = 0;
  std::array<int32_t, 3> counts{};
  std::array<int16_t, 4> orientation{0, 0, 0, 32767};
  uint16_t bur_speed_krpm = 0;
  std::array<int32_t, 3> rest_nm{};
  uint16_t share = 0;
  uint32_t energy_nj = 0, work_nj = 0;

  bool operator==(const InputReport&) const = default;
};

// EnForceReport.
struct OutputReport {
  bool motors_on = false;
  uint32_t sequence = 0;
  std::array<int32_t, 3> force_100un{};
  std::array<int32_t, 3> torque_un_m{};
  uint16_t watchdog_ms = 20;

  bool operator==(const OutputReport&) const = default;
};

// EnSpringReport.
struct SpringReport {
  bool motors_on = false, spring_on = false, follow = false;
  uint32_t sequence = 0;
  std::array<int32_t, 3> rest_nm{};
  std::array<int16_t, 3> force_100un{}, torque_20un_m{};
  uint16_t share = 65535, bound_mn = 65535;
  std::array<int16_t, 9> cell_nm{};

  bool operator==(const SpringReport&) const = default;
};

// `command` in board axes, zero as of the counts: motors on, all of the share, and the board's own cell.
// Added force and torque beyond what the report holds keep their direction.
SpringReport ReportOf(const SpringCommand& command, uint32_t sequence) noexcept;

struct FeatureReport {
  uint8_t axes = 3;
  bool tells_orientation = false;
  std::array<uint32_t, 3> resolution_nm{};
  std::array<uint32_t, 3> peak_force_mn{};
  uint16_t max_watchdog_ms = 0;
  uint16_t rate_hz = 0;
  std::string name, profile;
  // Of the spring that the board runs; all 0: it runs none.
  uint32_t spring_kc_mn_per_mm = 0;
  uint16_t spring_rate_hz = 0;
  uint8_t spring_delay_ticks = 0;
  bool runs_spring() const noexcept { return spring_kc_mn_per_mm > 0; }

  bool operator==(const FeatureReport&) const = default;
};

enum class ReportError : uint8_t {
  kNone = kEnWhole,
  kShort = kEnShort,
  kWrongId = kEnWrongId,
  kVersion = kEnVersion,
  kChecksum = kEnChecksum,
  kRange
};
// "shorter than its 48 bytes", …: ends a sentence.
const char* ReportErrorText(ReportError error) noexcept;

// `out` is unchanged unless kNone is returned.
ReportError DecodeInput(ByteView bytes, InputReport& out) noexcept;
ReportError DecodeOutput(ByteView bytes, OutputReport& out) noexcept;
ReportError DecodeSpring(ByteView bytes, SpringReport& out) noexcept;
ReportError DecodeFeature(ByteView bytes, FeatureReport& out);

std::array<uint8_t, kInputBytes> EncodeInput(const InputReport& report) noexcept;
std::array<uint8_t, kOutputBytes> EncodeOutput(const OutputReport& report) noexcept;
std::array<uint8_t, kSpringBytes> EncodeSpring(const SpringReport& report) noexcept;
std::array<uint8_t, kFeatureBytes> EncodeFeature(const FeatureReport& report) noexcept;

}  // namespace enamel::station::hid
