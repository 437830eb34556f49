#include "station/desk/watch/stillness.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace enamel::station::desk {

void StillnessCheck::Look(const DeviceSample& sample, double now_s) {
  now_s_ = now_s;
  auto begin_anew = [&](const char* wanted) {
    wanted_ = wanted;
    at_ = sample.counts;
    since_s_ = now_s;
  };
  if (!sample.attached) return begin_anew("ready.plug_in");
  if (sample.buttons & kPutDown) return begin_anew("ready.take_up");
  if (sample.buttons & kPedal) return begin_anew("ready.foot_off");
  double moved = 0;
  for (size_t i = 0; i < 3; ++i) {
    // Relative to the start of the rest, not to the last sample: a slow drift is motion too.
    moved = std::max(moved, std::fabs(static_cast<double>(sample.counts[i]) - at_[i]));
  }
  if (since_s_ < 0) return begin_anew("");
  if (moved * resolution_m_ > kAllowed_m) return begin_anew("ready.hold_still");
}

double StillnessCheck::share() const {
  return since_s_ < 0 ? 0 : std::clamp((now_s_ - since_s_) / kWanted_s, 0.0, 1.0);
}

}  // namespace enamel::station::desk
