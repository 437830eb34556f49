#include <algorithm>
#include <cmath>

#include "common/haptics/coupling.h"
#include "common/scoring/metrics.h"

namespace enamel::scoring {
namespace {

constexpr uint32_t kSampleRate_hz = 50;
constexpr uint32_t kCuttingWindows_per_s = 20;  // 50 ms
constexpr double kForceUnit_n = 1e-4;
constexpr double kAnchorUnit_m = 1e-8;
// Bins and not the forces themselves: an attempt of any length takes 400 kB and no sorting.
constexpr size_t kForceBins = 100'000;  // 100 N; more is counted in the last bin

dvec3 ToVec(const std::array<int32_t, 3>& v, double unit) {
  return dvec3(v[0] * unit, v[1] * unit, v[2] * unit);
}

double Length(const dvec3& v) { return std::sqrt(Dot(v, v)); }

}  // namespace

ProcessRecorder::ProcessRecorder(const core::CoreParams& params)
    : rate_hz_(params.rate_hz),
      decimation_(std::max(1u, (params.rate_hz + kSampleRate_hz - 1) / kSampleRate_hz)),
      cutting_window_(
          params.core_version >= 4 ? std::max(1u, params.rate_hz / kCuttingWindows_per_s) : 1),
      force_histogram_(kForceBins) {
  for (int i = 0; i < 3; ++i) {
    origin_m_[i] = static_cast<double>(params.device_origin_nm[static_cast<size_t>(i)]) * 1e-9;
  }
}

void ProcessRecorder::Add(const trace::Tick& tick, const core::TickOutput& output) {
  bool cutting = std::any_of(output.removed.begin(), output.removed.end(),
                             [](int64_t units) { return units != 0; });
  AddWitness(tick.input, output.witness, cutting);
}

void ProcessRecorder::AddRecorded(const trace::Tick& tick) {
  AddWitness(tick.input, tick.witness, false);
}

void ProcessRecorder::AddWitness(const core::TickInput& input, const core::TickWitness& witness,
                                 bool cutting) {
  gap_ticks_ += input.gap_ticks;
  late_ticks_ += (input.flags & core::kLateTick) != 0;
  bounded_ticks_ += (witness.flags & haptics::kPeakBounded) != 0;

  dvec3 force = ToVec(core::PressedForce_100un(witness), kForceUnit_n);
  double magnitude = Length(force);
  max_force_n_ = std::max(max_force_n_, magnitude);
  if (magnitude > 0) {
    auto bin = static_cast<size_t>(std::min(magnitude * 1e3 + 0.5, kForceBins - 1.0));
    ++force_histogram_[bin];
    ++force_ticks_;
  }
  if (cutting) cutting_left_ = cutting_window_;
  if (cutting_left_ > 0) {
    --cutting_left_;
    ++cutting_time_ticks_;
  }
  if (cutting) {
    ++cutting_ticks_;
    cutting_force_sum_n_ += magnitude;
  }

  dvec3 anchor = origin_m_ + ToVec(witness.anchor_10nm, kAnchorUnit_m);
  if (ticks_ > 0 && (witness.flags & core::kAnchorReset) == 0)
    path_m_ += Length(anchor - last_anchor_);
  last_anchor_ = anchor;

  // By ticks, not by time: a gap shortens no stretch, its length is in time_s.
  uint64_t in_stretch = ticks_ % decimation_;
  if (in_stretch == 0) {
    samples_.push_back(
        {static_cast<double>(ticks_ + gap_ticks_) / rate_hz_, anchor, force, path_m_});
  } else {
    PathSample& s = samples_.back();
    s.force_n += (force - s.force_n) / static_cast<double>(in_stretch + 1);
  }
  ++ticks_;
}

double ProcessRecorder::duration_s() const {
  return static_cast<double>(ticks_ + gap_ticks_) / rate_hz_;
}

double ProcessRecorder::cutting_s() const {
  return static_cast<double>(cutting_time_ticks_) / rate_hz_;
}

double ProcessRecorder::force_sent_p95_n() const {
  uint64_t seen = 0;
  for (size_t bin = 0; bin < force_histogram_.size(); ++bin) {
    seen += force_histogram_[bin];
    // 95 of 100 in whole numbers.
    if (seen * 20 >= force_ticks_ * 19 && seen > 0) return static_cast<double>(bin) * 1e-3;
  }
  return 0;
}

double ProcessRecorder::force_sent_mean_cutting_n() const {
  return cutting_ticks_ == 0 ? 0 : cutting_force_sum_n_ / static_cast<double>(cutting_ticks_);
}

}  // namespace enamel::scoring
