#include "station/hid/emulated_board.h"

#include <bit>
#include <cmath>

#include "common/scene/cell.h"
#include "common/scene/rate.h"

namespace enamel::station::hid {

Result<std::unique_ptr<EmulatedBoard>> EmulatedBoard::Make(const EmulatedBoardSettings& s) {
  const int64_t inner_hz = int64_t{s.rate_hz} * s.inner_ticks;
  const int64_t most =
      scene::LargestCouplingAt(s.profile, inner_hz, s.delay_ticks).coupling_mn_per_mm;
  std::unique_ptr<EmulatedBoard> made(new EmulatedBoard(s));
  const scene::TipCellNm cell = scene::TipCellOf(s.profile);
  EnBoardParams p{};
  p.tick_s = 1.0 / static_cast<double>(inner_hz);
  p.delay_ticks = s.delay_ticks;
  p.kc_n_per_m = static_cast<double>(s.kc_mn_per_mm);
  p.cell.half_m = {cell.half_nm * 1e-9, cell.half_nm * 1e-9, cell.half_nm * 1e-9};
  p.cell.ball_m = cell.ball_nm * 1e-9;
  p.peak_n = static_cast<double>(s.profile.peak_force_mn.value) * 1e-3;
  p.damping_n_s_per_m = static_cast<double>(s.profile.viscous_mn_s_per_m()) * 1e-3;
  if (s.kc_mn_per_mm > most || !EnBoardStart(&made->board_, &p)) {
    return Status(Code::kInvalidInput,
                  "a spring of " + std::to_string(s.kc_mn_per_mm) + " mN/mm at " +
                      std::to_string(inner_hz) + " Hz, " + std::to_string(s.delay_ticks) +
                      " ticks of delay: device profile '" + s.profile.name + "' allows 1 to " +
                      std::to_string(most),
                  "kc_mn_per_mm");
  }
  return made;
}

FeatureReport EmulatedBoard::feature() const {
  FeatureReport f;
  f.resolution_nm.fill(static_cast<uint32_t>(scene::CountNm(settings_.profile)));
  f.peak_force_mn.fill(static_cast<uint32_t>(settings_.profile.peak_force_mn.value));
  f.max_watchdog_ms = 100;
  f.rate_hz = static_cast<uint16_t>(settings_.rate_hz);
  f.name = Name();
  f.profile = settings_.profile.name;
  f.spring_kc_mn_per_mm = static_cast<uint32_t>(settings_.kc_mn_per_mm);
  f.spring_rate_hz =
      static_cast<uint16_t>(settings_.rate_hz * static_cast<uint32_t>(settings_.inner_ticks));
  f.spring_delay_ticks = static_cast<uint8_t>(settings_.delay_ticks);
  return f;
}

std::array<int32_t, 3> EmulatedBoard::CountsAt(double t_s) const {
  const dvec3 tip = settings_.hand(t_s);
  std::array<int32_t, 3> counts;
  for (int i = 0; i < 3; ++i) {
    counts[static_cast<size_t>(i)] =
        static_cast<int32_t>(std::lround(tip[i] * 1e9 / scene::CountNm(settings_.profile)));
  }
  return counts;
}

DeviceSample EmulatedBoard::ReadSample() noexcept {
  const double cell_m = scene::CountNm(settings_.profile) * 1e-9;
  InputReport report;
  for (int i = 0; i < settings_.inner_ticks; ++i) {
    report.counts = CountsAt(static_cast<double>(++ticks_) * board_.params.tick_s);
    const EnVec force = EnBoardTick(
        &board_, {report.counts[0] * cell_m, report.counts[1] * cell_m, report.counts[2] * cell_m});
    force_n_ = dvec3(force.x, force.y, force.z);
  }
  auto raw = std::bit_cast<EnPoseReport>(report);
  EnBoardTell(&board_, &raw);
  raw.status = EnBoardDrives(&board_) ? kMotorsOn : 0;
  raw.sequence = static_cast<uint32_t>(ticks_);
  uint8_t bytes[kEnPoseBytes];
  EnWritePose(&raw, bytes);
  ENAMEL_CHECK(DecodeInput(bytes, report) == ReportError::kNone);
  DeviceSample sample;
  sample.counts = report.counts;
  sample.rest_nm = report.rest_nm;
  sample.share = report.share;
  sample.buttons = kPedal;
  sample.bur_speed_krpm = kTurbineSpeed_krpm;
  sample.sequence = report.sequence;
  return sample;
}

void EmulatedBoard::SendForceAndTorque(const dvec3& force_n, const dvec3&) noexcept {
  OutputReport report;
  report.sequence = ++sequence_;
  for (int i = 0; i < 3; ++i)
    report.force_100un[static_cast<size_t>(i)] =
        static_cast<int32_t>(std::lround(force_n[i] * 1e4));
  const auto bytes = EncodeOutput(report);
  if (heard_) EnBoardReceive(&board_, bytes.data(), bytes.size());
}

void EmulatedBoard::SendSpring(const SpringCommand& command) noexcept {
  const auto bytes = EncodeSpring(ReportOf(command, ++sequence_));
  if (heard_) EnBoardReceive(&board_, bytes.data(), bytes.size());
}

}  // namespace enamel::station::hid
