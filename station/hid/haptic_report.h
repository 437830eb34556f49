#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/base/bytes.h"

// The three reports of a haptic board as bytes: schemas/hid_haptic_report.md. Pure functions, any
// thread. Real-time: decoding input and encoding output are safe.
namespace enamel::station::hid {

inline constexpr uint8_t kInputId = 0x48, kOutputId = 0x46, kFeatureId = 0x44;
inline constexpr uint8_t kReportVersion = 1;
inline constexpr size_t kInputBytes = 48, kOutputBytes = 36, kFeatureBytes = 98;
inline constexpr uint16_t kBoardUsagePage = 0xFF45, kBoardUsage = 0x0001;

enum BoardStatus : uint8_t {
  kMotorsOn = 1 << 0,
  kWatchdogTripped = 1 << 1,
  kNotFit = 1 << 2,
  kOrientationValid = 1 << 3,
};

struct InputReport {
  uint8_t status = 0;  // BoardStatus
  uint8_t buttons = 0;
  uint32_t sequence = 0;
  uint32_t time_us = 0;
  std::array<int32_t, 6> counts{};
  std::array<int16_t, 4> orientation{0, 0, 0, 32767};
  uint16_t bur_speed_krpm = 0;

  bool operator==(const InputReport&) const = default;
};

struct OutputReport {
  bool motors_on = false;
  uint32_t sequence = 0;
  std::array<int32_t, 3> force_100un{};
  std::array<int32_t, 3> torque_un_m{};
  uint16_t watchdog_ms = 20;

  bool operator==(const OutputReport&) const = default;
};

struct FeatureReport {
  uint8_t axes = 3;
  bool tells_orientation = false;
  std::array<uint32_t, 3> resolution_nm{};
  std::array<uint32_t, 3> peak_force_mn{};
  uint16_t max_watchdog_ms = 0;
  uint16_t rate_hz = 0;
  std::string name, profile;

  bool operator==(const FeatureReport&) const = default;
};

enum class ReportError : uint8_t { kNone = 0, kShort, kWrongId, kVersion, kChecksum, kRange };
// "shorter than its 48 bytes", …: ends a sentence.
const char* ReportErrorText(ReportError error) noexcept;

// `out` is unchanged unless kNone is returned.
ReportError DecodeInput(ByteView bytes, InputReport& out) noexcept;
ReportError DecodeOutput(ByteView bytes, OutputReport& out) noexcept;
ReportError DecodeFeature(ByteView bytes, FeatureReport& out);

std::array<uint8_t, kInputBytes> EncodeInput(const InputReport& report) noexcept;
std::array<uint8_t, kOutputBytes> EncodeOutput(const OutputReport& report) noexcept;
std::array<uint8_t, kFeatureBytes> EncodeFeature(const FeatureReport& report) noexcept;

// CRC-16/CCITT-FALSE.
uint16_t Crc16(ByteView bytes) noexcept;

}  // namespace enamel::station::hid
