#include "station/render/quality.h"

#include <algorithm>

namespace enamel::station::render {
namespace {

// A level up costs up to four times as much, so there must be room for it, for some time.
constexpr double kEasyShare = 0.2;
constexpr size_t kEasyWindows = 4;

}  // namespace

const Quality* FindQuality(std::string_view name) {
  for (const Quality& quality : kQualities) {
    if (quality.name == name) return &quality;
  }
  return nullptr;
}

Quality WhileTurning(const Quality& quality) {
  constexpr int kSamples = 8;
  Quality out = quality;
  out.occlusion_samples = std::min(quality.occlusion_samples, kSamples);
  out.coarse = true;
  return out;
}

QualityGovernor::QualityGovernor(size_t first_level, double budget_s)
    : budget_s_(budget_s), level_(std::min(first_level, kQualities.size() - 1)) {}

bool QualityGovernor::Note(double picture_s) {
  times_s_[count_++] = picture_s;
  if (count_ < kWindow) return false;
  count_ = 0;
  std::nth_element(times_s_.begin(), times_s_.begin() + kWindow / 2, times_s_.end());
  double median = times_s_[kWindow / 2];
  easy_windows_ = median < kEasyShare * budget_s_ ? easy_windows_ + 1 : 0;
  if (median > budget_s_ && level_ + 1 < kQualities.size()) {
    ++level_;
    return true;
  }
  if (easy_windows_ >= kEasyWindows && level_ > 0 && rises_ < kMaxRises) {
    --level_;
    ++rises_;
    easy_windows_ = 0;
    return true;
  }
  return false;
}

}  // namespace enamel::station::render
