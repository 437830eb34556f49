#include "station/hid/haptic_report.h"

#include <algorithm>

namespace enamel::station::hid {
namespace {

constexpr size_t kTextBytes = 32;

// Little-endian into a fixed report: ByteWriter allocates, and this runs beside the tick.
template <size_t N>
class FixedWriter {
 public:
  void U8(uint8_t v) noexcept { Little(v, 1); }
  void U16(uint16_t v) noexcept { Little(v, 2); }
  void U32(uint32_t v) noexcept { Little(v, 4); }
  void I16(int16_t v) noexcept { U16(static_cast<uint16_t>(v)); }
  void I32(int32_t v) noexcept { U32(static_cast<uint32_t>(v)); }
  void Text(std::string_view text) noexcept {
    for (size_t i = 0; i < kTextBytes; ++i) U8(i < text.size() ? static_cast<uint8_t>(text[i]) : 0);
  }
  std::array<uint8_t, N> WithChecksum() noexcept {
    U16(Crc16({bytes_.data(), at_}));
    return bytes_;
  }

 private:
  void Little(uint32_t v, size_t n) noexcept {
    for (size_t i = 0; i < n; ++i) bytes_[at_++] = static_cast<uint8_t>(v >> (8 * i));
  }
  std::array<uint8_t, N> bytes_{};
  size_t at_ = 0;
};

ReportError Check(ByteView bytes, uint8_t id, size_t size) noexcept {
  if (bytes.empty()) return ReportError::kShort;
  if (bytes[0] != id) return ReportError::kWrongId;
  if (bytes.size() < 2) return ReportError::kShort;
  // Before the length: another version may have another one, and must not be called short.
  if (bytes[1] != kReportVersion) return ReportError::kVersion;
  if (bytes.size() < size) return ReportError::kShort;
  // At the layout's end, not the report's: the rest is padding of the bus.
  uint16_t crc = static_cast<uint16_t>(bytes[size - 2] | bytes[size - 1] << 8);
  return Crc16(bytes.first(size - 2)) == crc ? ReportError::kNone : ReportError::kChecksum;
}

std::string ReadText(ByteReader& in) {
  std::string_view field = AsText(in.Raw(kTextBytes));
  return std::string(field.substr(0, field.find('\0')));
}

bool Within(uint32_t value, uint32_t low, uint32_t high) { return value >= low && value <= high; }

// As for a profile (common/scene/json/profile.cpp): the core must be able to run with it.
bool InRange(const FeatureReport& f) {
  bool ok =
      Within(f.axes, 3, 6) && Within(f.max_watchdog_ms, 1, 1000) && Within(f.rate_hz, 100, 20'000);
  for (uint32_t r : f.resolution_nm) ok = ok && Within(r, 1, 1'000'000);
  for (uint32_t p : f.peak_force_mn) ok = ok && Within(p, 1, 100'000);
  return ok;
}

}  // namespace

const char* ReportErrorText(ReportError error) noexcept {
  switch (error) {
    case ReportError::kNone:
      return "right";
    case ReportError::kShort:
      return "shorter than its layout";
    case ReportError::kWrongId:
      return "of another report id";
    case ReportError::kVersion:
      return "of another version than 1: update the station or the board";
    case ReportError::kChecksum:
      return "damaged (its checksum is wrong)";
    case ReportError::kRange:
      return "out of range";
  }
  return "";
}

uint16_t Crc16(ByteView bytes) noexcept {
  // Bit by bit: two reports of some 40 bytes a millisecond need no table.
  uint32_t crc = 0xFFFF;
  for (uint8_t byte : bytes) {
    crc ^= static_cast<uint32_t>(byte) << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x8000) ? (crc << 1) ^ 0x1021 : crc << 1;
    crc &= 0xFFFF;
  }
  return static_cast<uint16_t>(crc);
}

ReportError DecodeInput(ByteView bytes, InputReport& out) noexcept {
  if (ReportError e = Check(bytes, kInputId, kInputBytes); e != ReportError::kNone) return e;
  ByteReader in(bytes.subspan(2));
  out.status = in.U8();
  out.buttons = in.U8();
  out.sequence = in.U32();
  out.time_us = in.U32();
  for (int32_t& c : out.counts) c = in.I32();
  for (int16_t& q : out.orientation) q = in.I16();
  out.bur_speed_krpm = in.U16();
  return ReportError::kNone;
}

ReportError DecodeOutput(ByteView bytes, OutputReport& out) noexcept {
  if (ReportError e = Check(bytes, kOutputId, kOutputBytes); e != ReportError::kNone) return e;
  ByteReader in(bytes.subspan(2));
  out.motors_on = (in.U8() & 1) != 0;
  in.U8();
  out.sequence = in.U32();
  for (int32_t& f : out.force_100un) f = in.I32();
  for (int32_t& t : out.torque_un_m) t = in.I32();
  out.watchdog_ms = in.U16();
  return ReportError::kNone;
}

ReportError DecodeFeature(ByteView bytes, FeatureReport& out) {
  if (ReportError e = Check(bytes, kFeatureId, kFeatureBytes); e != ReportError::kNone) return e;
  ByteReader in(bytes.subspan(2));
  // Into a temporary: `out` does not change if a value is out of range.
  FeatureReport f;
  f.axes = in.U8();
  f.tells_orientation = (in.U8() & 1) != 0;
  for (uint32_t& r : f.resolution_nm) r = in.U32();
  for (uint32_t& p : f.peak_force_mn) p = in.U32();
  f.max_watchdog_ms = in.U16();
  f.rate_hz = in.U16();
  f.name = ReadText(in);
  f.profile = ReadText(in);
  if (!InRange(f)) return ReportError::kRange;
  out = std::move(f);
  return ReportError::kNone;
}

std::array<uint8_t, kInputBytes> EncodeInput(const InputReport& report) noexcept {
  FixedWriter<kInputBytes> out;
  out.U8(kInputId);
  out.U8(kReportVersion);
  out.U8(report.status);
  out.U8(report.buttons);
  out.U32(report.sequence);
  out.U32(report.time_us);
  for (int32_t c : report.counts) out.I32(c);
  for (int16_t q : report.orientation) out.I16(q);
  out.U16(report.bur_speed_krpm);
  return out.WithChecksum();
}

std::array<uint8_t, kOutputBytes> EncodeOutput(const OutputReport& report) noexcept {
  FixedWriter<kOutputBytes> out;
  out.U8(kOutputId);
  out.U8(kReportVersion);
  out.U8(report.motors_on ? 1 : 0);
  out.U8(0);
  out.U32(report.sequence);
  for (int32_t f : report.force_100un) out.I32(f);
  for (int32_t t : report.torque_un_m) out.I32(t);
  out.U16(report.watchdog_ms);
  return out.WithChecksum();
}

std::array<uint8_t, kFeatureBytes> EncodeFeature(const FeatureReport& report) noexcept {
  FixedWriter<kFeatureBytes> out;
  out.U8(kFeatureId);
  out.U8(kReportVersion);
  out.U8(report.axes);
  out.U8(report.tells_orientation ? 1 : 0);
  for (uint32_t r : report.resolution_nm) out.U32(r);
  for (uint32_t p : report.peak_force_mn) out.U32(p);
  out.U16(report.max_watchdog_ms);
  out.U16(report.rate_hz);
  out.Text(report.name);
  out.Text(report.profile);
  return out.WithChecksum();
}

}  // namespace enamel::station::hid
