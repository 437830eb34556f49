#include "station/hid/haptic_report.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace enamel::station::hid {
namespace {

constexpr size_t kTextBytes = 32;
constexpr uint8_t kTellsOrientation = 1, kRunsSpring = 2;  // flags of the feature report

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
    U16(EnCrc16(bytes_.data(), at_));
    return bytes_;
  }

 private:
  void Little(uint32_t v, size_t n) noexcept {
    for (size_t i = 0; i < n; ++i) bytes_[at_++] = static_cast<uint8_t>(v >> (8 * i));
  }
  std::array<uint8_t, N> bytes_{};
  size_t at_ = 0;
};

// In counts of `unit`, shortened to what 16 bits hold.
std::array<int16_t, 3> InUnits(const dvec3& v, double unit) noexcept {
  constexpr double kMost = 32767;
  const double largest = std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])}) / unit;
  if (!std::isfinite(largest)) return {};
  const double share = largest > kMost ? kMost / largest : 1;
  std::array<int16_t, 3> out{};
  for (int i = 0; i < 3; ++i)
    out[static_cast<size_t>(i)] = static_cast<int16_t>(std::lround(v[i] / unit * share));
  return out;
}

ReportError Check(ByteView bytes, uint8_t id, size_t size) noexcept {
  return static_cast<ReportError>(EnCheckReport(bytes.data(), bytes.size(), id, size));
}

// As the board's firmware reads it.
template <typename Raw, typename Report>
ReportError ReadAsBoard(EnReportError (*read)(const uint8_t*, size_t, Raw*), ByteView bytes,
                        Report& out) noexcept {
  Raw raw{};
  const EnReportError error = read(bytes.data(), bytes.size(), &raw);
  if (error == kEnWhole) out = std::bit_cast<Report>(raw);
  return static_cast<ReportError>(error);
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
  if (!f.runs_spring()) return ok;
  return ok && Within(f.spring_kc_mn_per_mm, 1, 1'000'000) &&
         Within(f.spring_rate_hz, f.rate_hz, 65'535) && Within(f.spring_delay_ticks, 0, 16);
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
  for (int32_t& r : out.rest_nm) r = in.I32();
  out.share = in.U16();
  out.energy_nj = in.U32();
  out.work_nj = in.U32();
  return ReportError::kNone;
}

ReportError DecodeOutput(ByteView bytes, OutputReport& out) noexcept {
  return ReadAsBoard(EnReadForce, bytes, out);
}

ReportError DecodeSpring(ByteView bytes, SpringReport& out) noexcept {
  return ReadAsBoard(EnReadSpring, bytes, out);
}

ReportError DecodeFeature(ByteView bytes, FeatureReport& out) {
  if (ReportError e = Check(bytes, kFeatureId, kFeatureBytes); e != ReportError::kNone) return e;
  ByteReader in(bytes.subspan(2));
  // Into a temporary: `out` does not change if a value is out of range.
  FeatureReport f;
  f.axes = in.U8();
  const uint8_t flags = in.U8();
  f.tells_orientation = (flags & kTellsOrientation) != 0;
  for (uint32_t& r : f.resolution_nm) r = in.U32();
  for (uint32_t& p : f.peak_force_mn) p = in.U32();
  f.max_watchdog_ms = in.U16();
  f.rate_hz = in.U16();
  f.name = ReadText(in);
  f.profile = ReadText(in);
  if (flags & kRunsSpring) {
    f.spring_kc_mn_per_mm = in.U32();
    f.spring_rate_hz = in.U16();
    f.spring_delay_ticks = in.U8();
    // Said to run, of no stiffness.
    if (!f.runs_spring()) return ReportError::kRange;
  }
  if (!InRange(f)) return ReportError::kRange;
  out = std::move(f);
  return ReportError::kNone;
}

std::array<uint8_t, kInputBytes> EncodeInput(const InputReport& report) noexcept {
  const auto raw = std::bit_cast<EnPoseReport>(report);
  std::array<uint8_t, kInputBytes> out;
  EnWritePose(&raw, out.data());
  return out;
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

SpringReport ReportOf(const SpringCommand& command, uint32_t sequence) noexcept {
  constexpr double kMaxBound_mn = 65'535;
  SpringReport report;
  report.motors_on = true;
  report.spring_on = command.on;
  report.follow = command.follow;
  report.sequence = sequence;
  report.rest_nm = command.rest_nm;
  report.force_100un = InUnits(command.added_n, 1e-4);
  report.torque_20un_m = InUnits(command.torque_n_m, 20e-6);
  report.bound_mn = static_cast<uint16_t>(std::clamp(command.bound_n * 1e3, 0.0, kMaxBound_mn));
  return report;
}

std::array<uint8_t, kSpringBytes> EncodeSpring(const SpringReport& report) noexcept {
  FixedWriter<kSpringBytes> out;
  out.U8(kSpringId);
  out.U8(kReportVersion);
  out.U8(static_cast<uint8_t>(report.motors_on | report.spring_on << 1 | report.follow << 2));
  out.U8(0);
  out.U32(report.sequence);
  for (int32_t r : report.rest_nm) out.I32(r);
  for (int16_t f : report.force_100un) out.I16(f);
  for (int16_t t : report.torque_20un_m) out.I16(t);
  out.U16(report.share);
  out.U16(report.bound_mn);
  for (int16_t c : report.cell_nm) out.I16(c);
  return out.WithChecksum();
}

std::array<uint8_t, kFeatureBytes> EncodeFeature(const FeatureReport& report) noexcept {
  FixedWriter<kFeatureBytes> out;
  out.U8(kFeatureId);
  out.U8(kReportVersion);
  out.U8(report.axes);
  out.U8(static_cast<uint8_t>((report.tells_orientation ? kTellsOrientation : 0) |
                              (report.runs_spring() ? kRunsSpring : 0)));
  for (uint32_t r : report.resolution_nm) out.U32(r);
  for (uint32_t p : report.peak_force_mn) out.U32(p);
  out.U16(report.max_watchdog_ms);
  out.U16(report.rate_hz);
  out.Text(report.name);
  out.Text(report.profile);
  out.U32(report.spring_kc_mn_per_mm);
  out.U16(report.spring_rate_hz);
  out.U8(report.spring_delay_ticks);
  out.U8(0);
  return out.WithChecksum();
}

}  // namespace enamel::station::hid
