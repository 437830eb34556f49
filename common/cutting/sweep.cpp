#include "common/cutting/sweep.h"

#include <cmath>

namespace enamel::cutting {
namespace {

double Length(const Quat& q) noexcept {
  return std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
}
double Length(const dvec3& v) noexcept { return std::sqrt(Dot(v, v)); }
Quat Difference(const Quat& a, const Quat& b) noexcept {
  return {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w};
}
double Dot4(const Quat& a, const Quat& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}

// Angle per length of difference (sweep.h). A quaternion that changed its sign would count as a
// long way: cut too often, never too seldom.
constexpr double kAnglePerQuat = 2.3;

}  // namespace

double Motion(const Pose& a, const Pose& b, double reach_m) noexcept {
  return Length(a.tip_m - b.tip_m) +
         kAnglePerQuat * reach_m * Length(Difference(a.orientation, b.orientation));
}

// How far a pose is from the straight way from the last cut to `to`: position and turn go together.
// A turn is weighted with the farthest point's way, so that the two can be added.
double Sweep::Deviation(const Pose& pose, const Pose& to) const noexcept {
  const double k = kAnglePerQuat * reach_;
  dvec3 way = to.tip_m - cut_.tip_m, off = pose.tip_m - cut_.tip_m;
  Quat turn = Difference(to.orientation, cut_.orientation),
       part = Difference(pose.orientation, cut_.orientation);
  double square = Dot(way, way) + k * k * Dot4(turn, turn);
  double share = square > 0 ? (Dot(way, off) + k * k * Dot4(turn, part)) / square : 0;
  share = share < 0 ? 0 : share > 1 ? 1 : share;
  Quat rest{part.x - turn.x * share, part.y - turn.y * share, part.z - turn.z * share,
            part.w - turn.w * share};
  return Length(off - way * share) + k * Length(rest);
}

void Sweep::CutAt(size_t i) noexcept {
  cut_ = due_[due_count_++] = waiting_[i];
  has_cut_ = true;
  for (size_t k = i + 1; k < count_; ++k) waiting_[k - i - 1] = waiting_[k];
  count_ -= i + 1;
  age_ = 0;
}

// Poses closer together than half the tolerance need not both be remembered.
void Sweep::Wait(const Pose& to) noexcept {
  const Pose& before = count_ >= 2 ? waiting_[count_ - 2] : cut_;
  bool replaces = count_ > 0 && Motion(before, to, reach_) < 0.5 * tolerance_;
  waiting_[replaces ? count_ - 1 : count_++] = to;
}

std::span<const Pose> Sweep::Move(const Pose& to) noexcept {
  due_count_ = 0;
  if (!has_cut_) {
    Wait(to);
    CutAt(count_ - 1);
    return {due_.data(), due_count_};
  }
  const double step = Motion(count_ > 0 ? waiting_[count_ - 1] : cut_, to, reach_);
  if (count_ == 0 && step == 0) return {};
  for (;;) {  // ends: every cut takes at least one pose from those that wait
    size_t worst = 0;
    double most = tolerance_;
    for (size_t i = 0; i < count_; ++i) {
      double deviation = Deviation(waiting_[i], to);
      if (deviation > most) most = deviation, worst = i + 1;
    }
    if (worst == 0) break;
    CutAt(worst - 1);
  }
  // No room to remember: what is newest stands for all of them, since none is off the way to it.
  if (count_ == kMaxWaiting) CutAt(count_ - 1);
  Wait(to);
  ++age_;
  // Cut now if one more step of this size would go beyond the span: then no hole lags by more.
  const double away = Motion(cut_, to, reach_);
  if (away + step > span_ || (age_ >= kPatience && away > tolerance_)) CutAt(count_ - 1);
  return {due_.data(), due_count_};
}

std::span<const Pose> Sweep::Flush() noexcept {
  due_count_ = 0;
  // The newest alone: those before it lie within the tolerance of the straight way to it.
  if (count_ > 0 && Motion(cut_, waiting_[count_ - 1], reach_) > tolerance_) CutAt(count_ - 1);
  count_ = 0;
  return {due_.data(), due_count_};
}

void Sweep::Clear() noexcept {
  has_cut_ = false;
  count_ = 0;
  age_ = 0;
}

}  // namespace enamel::cutting
