#include "station/desk/held_device.h"

#include <numbers>
#include <utility>

namespace enamel::station::desk {
namespace {

constexpr double kHalf = std::numbers::sqrt2 / 2;
// About z, by quarters.
constexpr Quat kTurns[4] = {
    {0, 0, 0, 1}, {0, 0, kHalf, kHalf}, {0, 0, 1, 0}, {0, 0, kHalf, -kHalf}};

}  // namespace

void HeldDevice::Turn(DeviceSample& sample, bool bur_on) noexcept {
  const unsigned wanted = wanted_quarters_.load(std::memory_order_relaxed);
  if (wanted != quarters_ && !bur_on) {
    sample.turned = read_;
    quarters_ = wanted;
  }
  read_ = true;
  if (quarters_ == 0) return;
  for (unsigned i = 0; i < quarters_; ++i) {
    std::swap(sample.counts[0], sample.counts[1]);
    sample.counts[0] = -sample.counts[0];
  }
  sample.orientation = ToQuantised(kTurns[quarters_] * FromQuantised(sample.orientation));
}

dvec3 HeldDevice::FromScene(const dvec3& v) const noexcept {
  dvec3 out = v;
  for (unsigned i = 0; i < quarters_; ++i) out = {out.y, -out.x, out.z};
  return out;
}

}  // namespace enamel::station::desk
