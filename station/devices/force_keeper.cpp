#include "station/devices/force_keeper.h"

#include <algorithm>
#include <cmath>

namespace enamel::station {

void ForceKeeper::Take(const dvec3& force_n, uint64_t number, int64_t now_us,
                       const dvec3& torque_n_m) noexcept {
  if (number == number_) return;
  number_ = number;
  const bool finite = std::isfinite(Dot(force_n, force_n) + Dot(torque_n_m, torque_n_m));
  force_n_ = finite ? force_n : dvec3(0);
  torque_n_m_ = finite ? torque_n_m : dvec3(0);
  taken_us_ = now_us;
  unsent_ = true;
}

std::optional<ForceKeeper::Command> ForceKeeper::Next(int64_t now_us) noexcept {
  if (!unsent_ && now_us < Due_us()) return std::nullopt;
  unsent_ = false;
  sent_us_ = now_us;
  int64_t age = now_us - taken_us_;
  if (number_ == 0 || age >= kGone_us) return Command{};
  double share = age <= kHold_us ? 1
                                 : static_cast<double>(kGone_us - age) /
                                       static_cast<double>(kGone_us - kHold_us);
  return Command{force_n_ * share, torque_n_m_ * share, true};
}

int64_t ForceKeeper::WaitFor_us(int64_t now_us) const noexcept {
  if (unsent_) return 0;
  return std::clamp<int64_t>(Due_us() - now_us, 0, repeat_us_);
}

int64_t ForceKeeper::Due_us() const noexcept {
  const int64_t gone_us = taken_us_ + kGone_us;
  bool held = number_ != 0 && sent_us_ < gone_us;
  return held ? std::min(sent_us_ + std::min(repeat_us_, kHold_us), gone_us)
              : sent_us_ + repeat_us_;
}

}  // namespace enamel::station
