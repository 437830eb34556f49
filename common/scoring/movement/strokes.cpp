#include "common/scoring/movement/strokes.h"

#include <algorithm>

namespace enamel::scoring {
namespace {

template <typename Values>
bool AnyOf(const Values& values) {
  return std::any_of(values.begin(), values.end(), [](auto v) { return v != 0; });
}

}  // namespace

StrokeRecorder::StrokeRecorder(const core::CoreParams& params)
    : rate_hz_(params.rate_hz), lift_ticks_(std::max(1u, params.rate_hz / 10)) {}

void StrokeRecorder::Close() {
  if (!open_) return;
  open_ = false;
  contact_ticks_ += now_.last_tick - now_.first_tick + 1;
  if (AnyOf(now_.removed)) strokes_.push_back(now_);
}

void StrokeRecorder::Add(const trace::Tick& tick, const core::TickOutput& output) {
  const uint64_t at = ticks_++;
  if (tick.input.gap_ticks > 0) {
    gaps_.push_back({at, (gaps_.empty() ? 0 : gaps_.back().sum) + tick.input.gap_ticks});
  }
  const bool broken = (output.witness.flags & core::kAnchorReset) != 0;
  if (open_ && (broken || at - now_.last_tick > lift_ticks_)) Close();
  if (!AnyOf(core::PressedForce_mn(output.witness)) && !AnyOf(output.removed)) return;
  if (!open_) {
    open_ = true;
    ++contacts_;
    now_ = Stroke();
    now_.first_tick = at;
    now_.first_s = TimeOf_s(at);
  }
  now_.last_tick = at;
  now_.last_s = TimeOf_s(at);
  for (size_t t = 0; t < now_.removed.size(); ++t) now_.removed[t] += output.removed[t];
}

std::vector<Stroke> StrokeRecorder::Strokes() const {
  std::vector<Stroke> out = strokes_;
  if (open_ && AnyOf(now_.removed)) out.push_back(now_);
  return out;
}

double StrokeRecorder::contact_s() const {
  const uint64_t lasting = open_ ? now_.last_tick - now_.first_tick + 1 : 0;
  return static_cast<double>(contact_ticks_ + lasting) / rate_hz_;
}

double StrokeRecorder::TimeOf_s(uint64_t tick) const {
  auto after = std::upper_bound(gaps_.begin(), gaps_.end(), tick,
                                [](uint64_t t, const Gap& gap) { return t < gap.tick; });
  const uint64_t missing = after == gaps_.begin() ? 0 : (after - 1)->sum;
  return static_cast<double>(tick + missing) / rate_hz_;
}

uint32_t StrokeRecorder::NumberAt(const std::vector<Stroke>& strokes, uint64_t tick) {
  auto after = std::upper_bound(strokes.begin(), strokes.end(), tick,
                                [](uint64_t t, const Stroke& s) { return t < s.first_tick; });
  if (after == strokes.begin() || (after - 1)->last_tick < tick) return 0;
  return static_cast<uint32_t>(after - strokes.begin());
}

}  // namespace enamel::scoring
