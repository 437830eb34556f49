#include "station/render/quality.h"

#include <algorithm>
#include <array>

namespace enamel::station::render {
namespace {

// What the level above may cost, as a multiple: four times the pixels, or more samples a pixel. There
// must be room for it, for some time.
constexpr std::array<double, kQualities.size()> kDearer = {1, 5, 2.5, 5};
// A level that was fast enough for so long has proved itself.
constexpr size_t kProved = 8;

}  // namespace

const Quality* FindQuality(std::string_view name) {
  for (const Quality& quality : kQualities) {
    if (quality.name == name) return &quality;
  }
  return nullptr;
}

Quality WhileTurning(const Quality& quality) {
  constexpr int kSamples = 8;
  // With a quarter of the pixels a picture is as like the full one as SSIM 0.95
  // (tests/station/mouth/turning_test.cpp), and costs a third where there is no graphics card.
  constexpr float kScale = 0.5f;
  Quality out = quality;
  out.occlusion_samples = std::min(quality.occlusion_samples, kSamples);
  out.scale = std::min(quality.scale, kScale);
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
  if (since_rise_ > 0 && ++since_rise_ > kProved) {
    since_rise_ = 0;
    wait_ = kShortestWait;
  }
  easy_windows_ = median * kDearer[level_] < budget_s_ ? easy_windows_ + 1 : 0;
  if (median > budget_s_ && level_ + 1 < kQualities.size()) {
    ++level_;
    if (since_rise_ > 0) wait_ = std::min(2 * wait_, kLongestWait);
    since_rise_ = easy_windows_ = 0;
    return true;
  }
  if (easy_windows_ >= wait_ && level_ > 0) {
    --level_;
    since_rise_ = 1;
    easy_windows_ = 0;
    return true;
  }
  return false;
}

}  // namespace enamel::station::render
