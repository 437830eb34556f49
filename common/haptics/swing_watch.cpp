#include "common/haptics/swing_watch.h"

#include <cmath>

#include "common/math/order.h"

namespace enamel::haptics {
namespace {

constexpr double kTwoPi = 6.283185307179586;

}  // namespace

SwingWatch::SwingWatch(const SwingWatchParams& params) : params_(params) {
  const double turn = kTwoPi * kBand_hz * params.tick_s;
  low_pass_ = turn / (1 + turn);
}

void SwingWatch::Forget() noexcept {
  slow_[0] = slow_[1] = farthest_ = dvec3(0);
  length_n_ = since_s_ = before_n_[0] = before_n_[1] = 0;
  count_ = 0;
}

dvec3 SwingWatch::AboveBand(dvec3 force) noexcept {
  for (dvec3& slow : slow_) {
    slow += (force - slow) * low_pass_;
    force -= slow;
  }
  return force;
}

void SwingWatch::Begin(const dvec3& at) noexcept {
  farthest_ = at;
  length_n_ = std::sqrt(Dot(at, at));
  since_s_ = 0;
}

void SwingWatch::EndHalfCycle() noexcept {
  const bool kept = length_n_ >= kKept * before_n_[0];
  before_n_[0] = before_n_[1];
  before_n_[1] = length_n_;
  count_ = kept ? count_ + 1 : count_ > 2 ? count_ - 2 : 0;
  if (count_ < params_.half_cycles) return;
  count_ = params_.half_cycles;
  if (kept) wanted_ = HigherOf(wanted_ * kFall, kMinShare);
}

double SwingWatch::Tick(const dvec3& force) noexcept {
  const dvec3 fast = AboveBand(force);
  const double length2 = Dot(fast, fast);
  since_s_ += params_.tick_s;
  if (length_n_ > 0 && since_s_ > kLongest_s) {
    length_n_ = before_n_[0] = before_n_[1] = 0;
    count_ = 0;
  }
  if (length_n_ > 0) {
    const double along = Dot(fast, farthest_) / length_n_;
    if (along <= -params_.least_n) {
      EndHalfCycle();
      Begin(fast);
    } else if (along > 0 && length2 > length_n_ * length_n_) {
      farthest_ = fast;
      length_n_ = std::sqrt(length2);
    }
  } else if (length2 >= params_.least_n * params_.least_n) {
    count_ = 1;
    Begin(fast);
  }
  if (share_ > wanted_)
    share_ = HigherOf(wanted_, share_ * (1 - LowerOf(1, kFall_per_s * params_.tick_s)));
  return share_;
}

void SwingWatch::VisitState(StateArchive& archive) {
  archive(slow_, farthest_, length_n_, since_s_, before_n_, count_, share_, wanted_);
}

}  // namespace enamel::haptics
