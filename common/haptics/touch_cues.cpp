#include "common/haptics/touch_cues.h"

#include <cmath>

#include "common/math/order.h"

namespace enamel::haptics {
namespace {

constexpr double kLowest_hz = 60, kHighest_hz = 230;
constexpr double kOfRate = 0.2;        // five values a period
constexpr double kTurnsPerWave = 40;   // of the bur, for one of the chatter
constexpr double kKnockPeriods = 1.5;  // until the knock has fallen to 1/e
constexpr double kKnockEnds = 0.01;    // of the largest force: over
constexpr double kFullSpeed_m_per_s = 0.02;
constexpr double kSmooth_s = 0.02;  // of the speed of approach
constexpr double kFree_s = 0.03;    // without tissue ahead before contact is news again
constexpr double kHalfHard_n_s_per_m = 1000;
constexpr double kHalfLoad_n = 1;

dvec3 Abs(const dvec3& v) noexcept { return dvec3(std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)); }

// Turns the unit vector (cos, sin) and takes the rounding out of its length.
void Turn(double turn_cos, double turn_sin, double& c, double& s) noexcept {
  double next_c = c * turn_cos - s * turn_sin, next_s = s * turn_cos + c * turn_sin;
  double length = std::sqrt(next_c * next_c + next_s * next_s);
  c = next_c / length;
  s = next_s / length;
}

}  // namespace

CueAccount::CueAccount(const CueAccountParams& params)
    : params_(params), balance_j_(params.energy_j) {
  ENAMEL_CHECK(params.delay_ticks >= 0 && params.delay_ticks <= kMaxDelay);
}

// The force felt on the way is, for each axis, a mean of the cues under way, whatever the delay.
void CueAccount::Book(const dvec3& moved) noexcept {
  double cost = 0;
  for (int i = 0; i < 3; ++i) {
    double most = sent_[0][i] * moved[i];
    for (int j = 1; j <= params_.delay_ticks; ++j) {
      most = HigherOf(most, sent_[static_cast<size_t>(j)][i] * moved[i]);
    }
    cost += most;
  }
  balance_j_ = LowerOf(balance_j_ + params_.power_w * params_.tick_s - cost, params_.energy_j);
}

void CueAccount::Gap(const dvec3& tip) noexcept {
  if (!started_) return;
  const dvec3 way = Abs(tip - tip_) + params_.cell_half_m * 2.0;
  double cost = 0;
  for (int i = 0; i < 3; ++i) {
    double most = 0;
    for (int j = 0; j <= params_.delay_ticks; ++j) {
      most = HigherOf(most, std::fabs(sent_[static_cast<size_t>(j)][i]));
    }
    cost += most * way[i];
  }
  balance_j_ = LowerOf(balance_j_ - cost, 0);
  sent_ = {};
  started_ = false;
}

// The largest share s such that the balance pays the worst case of what is under way with s times
// the cue among it, should it be the last (README.md). The need is convex in s, so a straight line
// between its ends lies above it.
double CueAccount::Share(const dvec3& wanted) const noexcept {
  const int d = params_.delay_ticks;
  const double tick = params_.tick_s;
  const dvec3 way =
      moved_ + params_.cell_half_m * 2.0 + dvec3((d + 1) * kFastest_m_per_s2 * tick * tick);
  double hidden = 0, least = 0, whole = 0;
  for (int i = 0; i < 3; ++i) {
    double before = 0;  // what was under way without the newest of it and with
    for (int j = 0; j < d; ++j) {
      before = HigherOf(before, std::fabs(sent_[static_cast<size_t>(j)][i]));
    }
    double felt = HigherOf(before, std::fabs(sent_[static_cast<size_t>(d)][i]));
    hidden += params_.cell_half_m[i] * felt;
    least += (d + 1) * way[i] * before;
    whole += (d + 1) * way[i] * HigherOf(before, std::fabs(wanted[i]));
  }
  const double room = balance_j_ - hidden;
  if (!(room > least)) return 0;
  return whole <= room ? 1 : (room - least) / (whole - least);
}

dvec3 CueAccount::Afford(const dvec3& tip, const dvec3& wanted) noexcept {
  const bool known = started_;
  const dvec3 moved = known ? tip - tip_ : dvec3(0);
  if (known) Book(moved);
  moved_ = Abs(moved);
  tip_ = tip;
  started_ = true;
  const double share = known && Dot(wanted, wanted) > 0 ? Share(wanted) : 0;
  const dvec3 cue = wanted * share;
  // What the cell hides of a change of force.
  const int d = params_.delay_ticks;
  for (int i = 0; i < 3; ++i) {
    double low = cue[i], high = cue[i];
    for (int j = 0; j < d; ++j) {
      low = LowerOf(low, sent_[static_cast<size_t>(j)][i]);
      high = HigherOf(high, sent_[static_cast<size_t>(j)][i]);
    }
    double low_before = sent_[static_cast<size_t>(d)][i], high_before = low_before;
    for (int j = 0; j < d; ++j) {
      low_before = LowerOf(low_before, sent_[static_cast<size_t>(j)][i]);
      high_before = HigherOf(high_before, sent_[static_cast<size_t>(j)][i]);
    }
    balance_j_ -= params_.cell_half_m[i] * HigherOf(high - low_before, high_before - low);
  }
  for (int j = d; j > 0; --j) sent_[static_cast<size_t>(j)] = sent_[static_cast<size_t>(j - 1)];
  sent_[0] = cue;
  return cue;
}

TouchCues::TouchCues(const TouchCueParams& params)
    : params_(params),
      account_(params.account),
      highest_hz_(LowerOf(kHighest_hz, kOfRate / params.account.tick_s)),
      enabled_((params.contact_n > 0 || params.chatter_n > 0) && params.account.energy_j > 0 &&
               highest_hz_ >= kLowest_hz) {}

void TouchCues::VisitState(StateArchive& archive) {
  account_.VisitState(archive);
  archive(tip_, velocity_, started_, engaged_, free_s_);
  archive(knock_n_, knock_cos_, knock_sin_, turn_cos_, turn_sin_, decay_);
  archive(chatter_cos_, chatter_sin_, chatter_turns_, chatter_turn_);
}

double TouchCues::Hardness(double b) noexcept { return b > 0 ? b / (b + kHalfHard_n_s_per_m) : 0; }

double TouchCues::KnockFrequency_hz(double b) const noexcept {
  return kLowest_hz + (highest_hz_ - kLowest_hz) * Hardness(b);
}

double TouchCues::ChatterFrequency_hz(double krpm) const noexcept {
  const double hz = krpm * (1000.0 / 60 / kTurnsPerWave);
  return hz < kLowest_hz ? kLowest_hz : LowerOf(hz, highest_hz_);
}

void TouchCues::NoteMotion(const dvec3& tip) noexcept {
  const double tick = params_.account.tick_s;
  if (started_) velocity_ += ((tip - tip_) / tick - velocity_) * (tick / (tick + kSmooth_s));
  tip_ = tip;
  started_ = true;
}

void TouchCues::NoteContact(const TouchCueInput& input) noexcept {
  if (!input.contact_read) return;
  if (input.engaged && !engaged_ && free_s_ >= kFree_s) StartKnock(input.tissue_b_n_s_per_m);
  engaged_ = input.engaged;
  free_s_ = engaged_ ? 0 : LowerOf(free_s_ + params_.account.tick_s, 1e9);
}

void TouchCues::StartKnock(double b) noexcept {
  const double tick = params_.account.tick_s;
  const dvec3& half = params_.account.cell_half_m;
  const double cell = 2 * HigherOf(half.x, HigherOf(half.y, half.z));
  const double speed = std::sqrt(Dot(velocity_, velocity_));
  if (!(speed > cell / kSmooth_s) || !(speed > 0)) return;  // no more than a tip on a cell's edge
  const double share = speed < kFullSpeed_m_per_s ? speed / kFullSpeed_m_per_s : 1;
  knock_n_ = velocity_ * (-params_.contact_n * share / speed);
  const double hz = KnockFrequency_hz(b);
  const SinCos turn = SinCosOfTurns(hz * tick);
  knock_cos_ = turn_cos_ = turn.cos;
  knock_sin_ = turn_sin_ = turn.sin;
  const double fades_s = kKnockPeriods / hz;
  decay_ = fades_s / (fades_s + tick);
  knock_n_ *= decay_;
}

dvec3 TouchCues::Knock() noexcept {
  const double ends = kKnockEnds * params_.contact_n;
  if (!(Dot(knock_n_, knock_n_) > ends * ends)) {
    knock_n_ = dvec3(0);
    return knock_n_;
  }
  const dvec3 out = knock_n_ * knock_sin_;
  Turn(turn_cos_, turn_sin_, knock_cos_, knock_sin_);
  knock_n_ *= decay_;
  return out;
}

dvec3 TouchCues::Chatter(const TouchCueInput& input) noexcept {
  const double load = std::sqrt(Dot(input.pressed_n, input.pressed_n));
  const double amplitude =
      params_.chatter_n * (load / (load + kHalfLoad_n)) * Hardness(input.tissue_b_n_s_per_m);
  if (!engaged_ || !(amplitude > 0) || !(input.bur_speed_krpm > 0)) {
    chatter_cos_ = 1;
    chatter_sin_ = 0;
    return dvec3(0);
  }
  const double turns = ChatterFrequency_hz(input.bur_speed_krpm) * params_.account.tick_s;
  if (turns != chatter_turns_) {
    chatter_turns_ = turns;
    chatter_turn_ = SinCosOfTurns(turns);
  }
  Turn(chatter_turn_.cos, chatter_turn_.sin, chatter_cos_, chatter_sin_);
  return input.across * (amplitude * chatter_sin_);
}

// The largest share s of the cue with |F + s c| <= peak; 0 where F alone reaches it.
dvec3 TouchCues::WithinPeak(const dvec3& f, const dvec3& c) const noexcept {
  const double peak = params_.peak_force_n;
  const dvec3 sum = f + c;
  if (!(Dot(sum, sum) > peak * peak)) return c;
  const double left = peak * peak - Dot(f, f), c2 = Dot(c, c), along = Dot(f, c);
  if (!(left > 0) || !(c2 > 0)) return dvec3(0);
  // s^2 c2 + 2 s along = left; the same root twice, without a difference of nearly equal numbers.
  const double root = std::sqrt(along * along + c2 * left);
  const double s = along > 0 ? left / (along + root) : (root - along) / c2;
  return s < 1 ? c * s : c;
}

dvec3 TouchCues::Tick(const TouchCueInput& input) noexcept {
  if (!enabled_) return dvec3(0);
  if (input.gap) {
    account_.Gap(input.tip_m);
    velocity_ = dvec3(0);
    started_ = false;
  }
  NoteMotion(input.tip_m);
  dvec3 wanted(0);
  if (input.suspended) {
    knock_n_ = dvec3(0);
    chatter_cos_ = 1;
    chatter_sin_ = 0;
    engaged_ = false;
    free_s_ = kFree_s;
  } else {
    NoteContact(input);
    wanted = Knock() + Chatter(input);
    if (input.bounded) wanted = dvec3(0);
    if (Dot(wanted, wanted) > 0) wanted = WithinPeak(input.coupling_n, wanted);
  }
  return account_.Afford(input.tip_m, wanted);
}

}  // namespace enamel::haptics
