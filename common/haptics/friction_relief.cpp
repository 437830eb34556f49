#include "common/haptics/friction_relief.h"

#include <cmath>

#include "common/math/order.h"

namespace enamel::haptics {
namespace {

// |R| below this share of c is not yet a direction: the push fades.
constexpr double kFade = 0.05;

double ShareLeftOut(double b, double kc, const OwnFriction& own) noexcept {
  const double half = kc * own.half_s;
  return half > 0 ? half / (half + b) : 0;
}

}  // namespace

dvec3 LessFriction(const dvec3& pull, double b, double kc, const OwnFriction& own) noexcept {
  const double share = ShareLeftOut(b, kc, own);
  dvec3 out = pull;
  for (int i = 0; i < 3; ++i) {
    const double c = share * own.c_n[i];
    if (!(c > 0)) continue;
    out[i] = pull[i] > c ? pull[i] - c : pull[i] < -c ? pull[i] + c : 0;
  }
  return out;
}

FrictionRelief::FrictionRelief(const OwnFriction& own, double kc, double tick_s, double radius_m,
                               bool soften) noexcept
    : own_(own),
      kc_(kc),
      tick_s_(tick_s),
      radius_m_(radius_m),
      soften_(soften && own.measured && kc > 0) {}

void FrictionRelief::Reset() noexcept {
  Forget();
  share_ = 1;
}

dvec3 FrictionRelief::Push(const dvec3& pull, double b, double kc) noexcept {
  if (!own_.measured) return dvec3(0);
  const double share = ShareLeftOut(b, kc_, own_);
  dvec3 wanted(0);
  double least = own_.c_n[0];
  for (int i = 0; i < 3; ++i) {
    const double c = own_.c_n[i], r = std::fabs(pull[i]), over = share * c - r;
    least = LowerOf(least, c);
    if (!(over > 0)) continue;
    const double push = over * LowerOf(1, r / (kFade * c));
    wanted[i] = pull[i] < 0 ? -push : push;
  }
  push_n_ += (wanted - push_n_) * (tick_s_ / (kRelief_s + tick_s_));
  // Friction along axes that are not known pays for any direction as far as its length goes.
  const double spare = HigherOf(0, least - kc * radius_m_);
  const double length = std::sqrt(Dot(push_n_, push_n_));
  if (length > spare) push_n_ *= spare / length;
  return push_n_;
}

double FrictionRelief::NextShare(double b) const noexcept {
  if (!soften_) return 1;
  // Nothing resists: all of the stiffness, for what the bur meets next.
  const double wanted = b > 0 ? Clamped(b / (own_.softest_s * kc_), kMinSoftness, 1) : 1;
  return share_ + (wanted - share_) * (tick_s_ / (kRelief_s + tick_s_));
}

void FrictionRelief::TakeShare(double next, double stretch_m, EnTank* tank) noexcept {
  double rise = next - share_;
  if (rise > 0) {
    const double reach = stretch_m + radius_m_, cost_j = 0.5 * rise * kc_ * reach * reach;
    const double paid_j = HigherOf(0, LowerOf(cost_j, tank->energy_j));
    if (paid_j < cost_j) rise *= paid_j / cost_j;
    tank->energy_j -= paid_j;
  }
  share_ += rise;
}

}  // namespace enamel::haptics
