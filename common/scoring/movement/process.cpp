#include "common/scoring/movement/process.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/haptics/coupling.h"
#include "common/math/trig.h"

namespace enamel::scoring {
namespace {

constexpr uint32_t kSampleRate_hz = 50;
constexpr uint32_t kCuttingWindows_per_s = 20;  // 50 ms
constexpr double kForceUnit_n = 1e-3;
constexpr double kAnchorUnit_m = 1e-7;
// Bins and not the forces themselves: an attempt of any length takes 400 kB and no sorting.
constexpr size_t kForceBins = 100'000;  // 100 N; more is counted in the last bin
constexpr uint32_t kBlocks_per_s = 100, kTenths_per_s = 10;
constexpr double kRateStep_n_per_s = 0.1, kAngleStep_deg = 0.1;
constexpr size_t kRateBins = 20'000, kAngleBins = 1801;
constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr double kMinStroke_s = 1;  // shorter ones have too few samples to tell 10 Hz from 1 Hz

dvec3 ToVec(const std::array<int32_t, 3>& v, double unit) {
  return dvec3(v[0] * unit, v[1] * unit, v[2] * unit);
}

double Length(const dvec3& v) { return std::sqrt(Dot(v, v)); }

// The bin at or below which 95 of 100 lie, in whole numbers.
size_t Bin95(const std::vector<uint32_t>& histogram, uint64_t count) {
  uint64_t seen = 0;
  for (size_t bin = 0; bin < histogram.size(); ++bin) {
    seen += histogram[bin];
    if (seen * 20 >= count * 19 && seen > 0) return bin;
  }
  return 0;
}

size_t BinOf(double value, double step, size_t bins) {
  return static_cast<size_t>(std::min(value / step + 0.5, static_cast<double>(bins) - 1));
}

std::optional<double> Median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

}  // namespace

ProcessRecorder::ProcessRecorder(const core::CoreParams& params)
    : rate_hz_(params.rate_hz),
      decimation_(std::max(1u, (params.rate_hz + kSampleRate_hz - 1) / kSampleRate_hz)),
      cutting_window_(std::max(1u, params.rate_hz / kCuttingWindows_per_s)),
      force_histogram_(kForceBins),
      block_ticks_(std::max(1u, params.rate_hz / kBlocks_per_s)),
      rate_histogram_(kRateBins),
      strokes_(params),
      tremor_(params.rate_hz),
      angle_histogram_(kAngleBins),
      tenth_ticks_(std::max(1u, params.rate_hz / kTenths_per_s)) {
  for (int i = 0; i < 3; ++i) {
    origin_m_[i] = static_cast<double>(params.device_origin_nm[static_cast<size_t>(i)]) * 1e-9;
    resolution_m_[i] = static_cast<double>(params.resolution_nm[static_cast<size_t>(i)]) * 1e-9;
  }
}

void ProcessRecorder::Add(const trace::Tick& tick, const core::TickOutput& output) {
  bool cutting = std::any_of(output.removed.begin(), output.removed.end(),
                             [](int64_t units) { return units != 0; });
  if (removed_.size() * tenth_ticks_ <= ticks_) removed_.resize(ticks_ / tenth_ticks_ + 1);
  if (cutting) {
    for (size_t t = 0; t < output.removed.size(); ++t) removed_.back()[t] += output.removed[t];
  }
  const bool sampled = ticks_ % decimation_ == 0;
  if (sampled) computed_m_.push_back(output.anchor.tip_m);
  strokes_.Add(tick, output);
  AddWitness(tick.input, output.witness, cutting);
  if (sampled && cutting_left_ > 0) AddAngle(tick.input.orientation);
  const bool broken = (output.witness.flags & core::kAnchorReset) != 0;
  tremor_.Add(last_tip_m_, strokes_.in_contact() && !broken);
}

void ProcessRecorder::AddRecorded(const trace::Tick& tick) {
  AddWitness(tick.input, tick.witness, false);
}

void ProcessRecorder::AddWitness(const core::TickInput& input, const core::TickWitness& witness,
                                 bool cutting) {
  gap_ticks_ += input.gap_ticks;
  late_ticks_ += (input.flags & core::kLateTick) != 0;
  // A fault may begin with a gap without force: both are one.
  const bool unfelt_gap = input.gap_ticks > 0 && (input.flags & core::kHeldGap) == 0;
  const bool was_faulted = std::exchange(is_faulted_, (input.flags & core::kFaulted) != 0);
  outages_ += (unfelt_gap || is_faulted_) && !was_faulted;
  bounded_ticks_ += (witness.flags & haptics::kPeakBounded) != 0;
  shook_ = shook_ || (witness.flags & core::kSwingSeen) != 0;

  dvec3 force = ToVec(core::PressedForce_mn(witness), kForceUnit_n);
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

  const bool broken = ticks_ == 0 || (witness.flags & core::kAnchorReset) != 0;
  impulse_n_s_ += magnitude / rate_hz_;
  // From the device's reading: the hand's way, against which the force was sent.
  const dvec3 tip(input.counts[0] * resolution_m_.x, input.counts[1] * resolution_m_.y,
                  input.counts[2] * resolution_m_.z);
  if (!broken) work_j_ -= Dot(last_force_n_, tip - last_tip_m_);
  last_tip_m_ = tip;
  last_force_n_ = force;
  AddForceRate(force, broken);

  dvec3 anchor = origin_m_ + ToVec(witness.anchor_100nm, kAnchorUnit_m);
  if (!broken) path_m_ += Length(anchor - last_anchor_);
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

void ProcessRecorder::AddForceRate(const dvec3& force, bool broken) {
  if (broken) {
    block_before_ = false;
    in_block_ = 0;
    block_sum_n_ = dvec3(0);
  }
  block_sum_n_ += force;
  if (++in_block_ < block_ticks_) return;
  const dvec3 mean = block_sum_n_ / static_cast<double>(block_ticks_);
  const bool any = Dot(mean, mean) > 0 || Dot(last_block_n_, last_block_n_) > 0;
  if (block_before_ && any) {
    const double rate = Length(mean - last_block_n_) * rate_hz_ / block_ticks_;
    ++rate_histogram_[BinOf(rate, kRateStep_n_per_s, kRateBins)];
    ++rates_;
  }
  last_block_n_ = mean;
  block_before_ = true;
  in_block_ = 0;
  block_sum_n_ = dvec3(0);
}

void ProcessRecorder::AddAngle(const QuantisedOrientation& orientation) {
  const dvec3 axis = FromQuantised(orientation).Matrix()[2];
  const double aside = std::sqrt(axis.x * axis.x + axis.y * axis.y);
  double angle = 90;
  if (axis.z > 0) angle = kDegrees * ArcTan(aside / axis.z);
  if (axis.z < 0) angle = 180 - kDegrees * ArcTan(aside / -axis.z);
  angle_sum_deg_ += angle;
  ++angles_;
  ++angle_histogram_[BinOf(angle, kAngleStep_deg, kAngleBins)];
}

double ProcessRecorder::force_rate_p95_n_per_s() const {
  return static_cast<double>(Bin95(rate_histogram_, rates_)) * kRateStep_n_per_s;
}

double ProcessRecorder::idle_s() const {
  return static_cast<double>(ticks_) / rate_hz_ - strokes_.contact_s();
}

std::optional<double> ProcessRecorder::angulation_mean_deg() const {
  if (angles_ == 0) return std::nullopt;
  return angle_sum_deg_ / static_cast<double>(angles_);
}

std::optional<double> ProcessRecorder::angulation_p95_deg() const {
  if (angles_ == 0) return std::nullopt;
  return static_cast<double>(Bin95(angle_histogram_, angles_)) * kAngleStep_deg;
}

std::optional<double> ProcessRecorder::half_removed_s(cutting::Tissue tissue) const {
  const auto t = static_cast<size_t>(tissue);
  int64_t all = 0, so_far = 0;
  for (const cutting::RemovedUnits& tenth : removed_) all += tenth[t];
  if (all <= 0) return std::nullopt;
  for (size_t i = 0; i < removed_.size(); ++i) {
    so_far += removed_[i][t];
    // At the end of the tenth in which it went.
    if (2 * so_far >= all) return strokes_.TimeOf_s(std::min((i + 1) * tenth_ticks_, ticks_ - 1));
  }
  return std::nullopt;
}

ProcessRecorder::Smoothness ProcessRecorder::MeasureSmoothness() const {
  const double rate_hz = static_cast<double>(rate_hz_) / decimation_;
  std::vector<double> jerks, arcs;
  const std::vector<Stroke> strokes = strokes_.Strokes();
  for (const Stroke& stroke : strokes) {
    const uint64_t first = (stroke.first_tick + decimation_ - 1) / decimation_;
    const uint64_t last = stroke.last_tick / decimation_;
    if (last < first || static_cast<double>(last - first) < kMinStroke_s * rate_hz) continue;
    std::vector<double> speed;
    for (uint64_t i = first; i < last; ++i) {
      speed.push_back(Length(computed_m_[i + 1] - computed_m_[i]) * rate_hz);
    }
    if (auto jerk = LogDimensionlessJerk(speed)) jerks.push_back(*jerk);
    if (auto arc = SpectralArcLength(speed, rate_hz)) arcs.push_back(*arc);
  }
  return {Median(std::move(jerks)), Median(std::move(arcs))};
}

double ProcessRecorder::duration_s() const {
  return static_cast<double>(ticks_ + gap_ticks_) / rate_hz_;
}

double ProcessRecorder::cutting_s() const {
  return static_cast<double>(cutting_time_ticks_) / rate_hz_;
}

double ProcessRecorder::force_sent_p95_n() const {
  return static_cast<double>(Bin95(force_histogram_, force_ticks_)) * 1e-3;
}

double ProcessRecorder::force_sent_mean_cutting_n() const {
  return cutting_ticks_ == 0 ? 0 : cutting_force_sum_n_ / static_cast<double>(cutting_ticks_);
}

}  // namespace enamel::scoring
