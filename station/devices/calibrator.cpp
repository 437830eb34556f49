// Motion of the device; its evaluation is in calibrator_figures.cpp.
#include "station/devices/calibrator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace enamel::station {
namespace {

// At rest for noise and the joints' cells; between swings until their start has died away.
constexpr double kRest_s = 2.0, kSettle_s = 1.0;
// A push lasts until the device has moved this far, or this long; the next one begins this much
// later. So short a way is many encoder cells but little of the workspace, so b, m and friction are
// those of one place.
constexpr double kPushReach_m = 1.5e-3, kPush_s = 0.06, kPulseEvery_s = 0.6;
// Share of the allowed force: inside the bound of Step, so that a push has one force throughout.
constexpr double kPulseShare = 0.8;
// Soft, so that the hold is stable without the figures being measured: sampled at 1 kHz it needs b
// >= K T / 2 = 0.075 N s/m, and adds forty times that itself.
constexpr double kHoldStiffness_n_per_m = 150, kHoldDamping_n_s_per_m = 3;
// Long enough that one encoder cell is a small velocity, short relative to a swing's quarter.
constexpr double kVelocityOver_s = 0.008;
constexpr double kSilence_s = 0.05;
// A swing goes one reach_m to each side: farther away, the device falls or a hand pulls it.
constexpr double kRunaway = 2.5;  // times reach_m

double Clamped(double v, double limit) noexcept { return std::clamp(v, -limit, limit); }

}  // namespace

// Slow swings show friction (the same force at every speed), fast ones mass (force with the square
// of the frequency); damping is the rest. The fastest has a smaller amplitude, so that its peak
// force stays within the limit.
const std::array<Calibrator::Swing, Calibrator::kSwingCount> Calibrator::kSwings = {
    {{0.5, 1.0, 3}, {1, 1.0, 4}, {2, 1.0, 6}, {4, 0.6, 8}}};

Calibrator::Calibrator(const CalibratorSetup& setup) : setup_(setup) {
  ENAMEL_CHECK(setup.tick_s > 0 && setup.max_force_n > 0 && setup.reach_m > 0);
  for (double m : setup.count_m) ENAMEL_CHECK(m > 0);
  auto ticks = [&](double s) { return static_cast<int64_t>(std::lround(s / setup_.tick_s)); };
  rest_ticks_ = ticks(kRest_s);
  pulse_ticks_ = ticks(kPulseEvery_s);
  push_limit_ = ticks(kPush_s);
  int64_t swings = 0;
  for (const Swing& s : kSwings) swings += TicksOf(s);
  total_ticks_ = rest_ticks_ + 3 * (kPulses * pulse_ticks_ + swings);
  counts_.reserve(static_cast<size_t>(total_ticks_) + 1);
  forces_.reserve(static_cast<size_t>(total_ticks_) + 1);
}

int64_t Calibrator::SettleTicks() const noexcept {
  return static_cast<int64_t>(kSettle_s / setup_.tick_s);
}

int64_t Calibrator::TicksOf(const Swing& swing) const noexcept {
  return SettleTicks() + std::lround(swing.periods / (swing.hz * setup_.tick_s));
}

double Calibrator::progress() const noexcept {
  return done() ? 1 : static_cast<double>(tick_) / static_cast<double>(total_ticks_);
}

std::string Calibrator::Doing() const {
  std::string axis(1, static_cast<char>('x' + axis_));
  switch (phase_) {
    case Phase::kRest:
      return "at rest: do not touch it";
    case Phase::kPulses:
      return "short pushes along " + axis + ": bus delay";
    case Phase::kSwings:
      return "swings along " + axis + ": friction, damping, mass";
    case Phase::kDone:
      return "done";
    case Phase::kFailed:
      return why_;
  }
  return "";
}

void Calibrator::Fail(const char* why) noexcept {
  phase_ = Phase::kFailed;
  why_ = why;
}

bool Calibrator::Watch(const DeviceSample& sample) noexcept {
  silent_ = sample.fresh ? 0 : silent_ + 1;
  if (!sample.attached) {
    Fail("the device was unplugged: plug it in and begin again");
  } else if (silent_ * setup_.tick_s > kSilence_s) {
    Fail("the device has gone silent: check its cable and begin again");
  }
  if (failed()) return false;
  counts_.push_back(sample.counts);
  if (tick_ < rest_ticks_) return true;
  for (size_t i = 0; i < 3; ++i) {
    double away = sample.counts[i] * setup_.count_m[i] - home_m_[i];
    if (std::fabs(away) > kRunaway * setup_.reach_m) {
      Fail(
          "the device ran away by more than was asked for: hold its arm up by its own balance or "
          "a rest, keep hands off, and begin again");
    }
  }
  return !failed();
}

dvec3 Calibrator::Step(const DeviceSample& sample) noexcept {
  if (done() || !Watch(sample)) return dvec3(0);
  dvec3 force(0);
  switch (phase_) {
    case Phase::kRest:
      force = Rest();
      break;
    case Phase::kPulses:
      force[static_cast<int>(axis_)] = Pulse();
      break;
    case Phase::kSwings:
      force[static_cast<int>(axis_)] = SwingForce();
      break;
    case Phase::kDone:
    case Phase::kFailed:
      break;
  }
  for (int i = 0; i < 3; ++i) force[i] = Clamped(force[i], setup_.max_force_n);
  if (done()) force = dvec3(0);
  forces_.push_back(
      {static_cast<float>(force.x), static_cast<float>(force.y), static_cast<float>(force.z)});
  ++tick_;
  ++phase_tick_;
  return force;
}

dvec3 Calibrator::Rest() noexcept {
  if (phase_tick_ + 1 < rest_ticks_) return dvec3(0);
  for (size_t i = 0; i < 3; ++i) home_m_[i] = counts_.back()[i] * setup_.count_m[i];
  phase_ = Phase::kPulses;
  phase_tick_ = -1;
  pulses_begin_[axis_] = tick_ + 1;
  return dvec3(0);
}

double Calibrator::Velocity() const noexcept {
  auto back = static_cast<size_t>(std::max(1.0, std::round(kVelocityOver_s / setup_.tick_s)));
  if (counts_.size() <= back) return 0;
  double way =
      (static_cast<double>(counts_.back()[axis_]) - counts_[counts_.size() - 1 - back][axis_]) *
      setup_.count_m[axis_];
  return way / (static_cast<double>(back) * setup_.tick_s);
}

double Calibrator::Hold(double target_m, double target_m_per_s) noexcept {
  double x = counts_.back()[axis_] * setup_.count_m[axis_] - home_m_[axis_];
  return kHoldStiffness_n_per_m * (target_m - x) +
         kHoldDamping_n_s_per_m * (target_m_per_s - Velocity());
}

// Half a second each: push, the opposite push to stop, then held at home.
double Calibrator::Pulse() noexcept {
  int64_t pulse = phase_tick_ / pulse_ticks_, at = phase_tick_ % pulse_ticks_;
  if (pulse == kPulses) {
    phase_ = Phase::kSwings;
    phase_tick_ = 0;
    swing_ = 0;
    swings_begin_[axis_] = tick_;
    return SwingForce();
  }
  double push = (pulse % 2 == 0 ? 1 : -1) * kPulseShare * setup_.max_force_n;
  if (at == 0) {
    push_from_m_ = counts_.back()[axis_] * setup_.count_m[axis_];
    push_ticks_ = 0;
  }
  double way = std::fabs(counts_.back()[axis_] * setup_.count_m[axis_] - push_from_m_);
  if (push_ticks_ == 0 && (way >= kPushReach_m || at >= push_limit_)) push_ticks_ = at;
  if (push_ticks_ == 0) return push;
  if (at < 2 * push_ticks_) return -push;
  // Releases early enough for the next pulse to begin from rest and without force.
  return at < pulse_ticks_ * 4 / 5 ? Hold(0, 0) : 0;
}

double Calibrator::SwingForce() noexcept {
  const Swing& swing = kSwings[swing_];
  if (phase_tick_ >= TicksOf(swing)) {
    phase_tick_ = 0;
    if (++swing_ == kSwings.size()) {
      NextAxis();
      return 0;
    }
    return SwingForce();
  }
  double amplitude = swing.amplitude_m * setup_.reach_m;
  double w = 2 * std::numbers::pi * swing.hz;
  double t = static_cast<double>(phase_tick_) * setup_.tick_s;
  return Hold(amplitude * std::sin(w * t), amplitude * w * std::cos(w * t));
}

void Calibrator::NextAxis() noexcept {
  if (++axis_ == 3) {
    axis_ = 2;
    phase_ = Phase::kDone;
    return;
  }
  phase_ = Phase::kPulses;
  phase_tick_ = -1;
  pulses_begin_[axis_] = tick_ + 1;
}

}  // namespace enamel::station
