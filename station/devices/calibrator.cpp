#include "station/devices/calibrator.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "common/haptics/criteria.h"

namespace enamel::station {
namespace {

using Complex = std::complex<double>;

constexpr double kRest_s = 2.0, kSettle_s = 1.0;
// A push lasts until the device has gone so far, or so long; the next one begins so much later.
constexpr double kPushReach_m = 1.5e-3, kPush_s = 0.06, kPulseEvery_s = 0.6;
constexpr double kPulseShare = 0.8;  // of the force it may use
constexpr double kHoldStiffness_n_per_m = 150, kHoldDamping_n_s_per_m = 3;
constexpr double kVelocityOver_s = 0.008;
constexpr double kSignOver_s = 0.010;
constexpr double kSilence_s = 0.05;
constexpr double kDelayStep_ticks = 0.05;
constexpr double kTwo95 = 1.96;
constexpr double kNotRoundedUp_ticks = 0.1 + 1e-9;
constexpr double kCellsMoved = 4;  // by a push, before its way says anything

double Clamped(double v, double limit) noexcept { return std::clamp(v, -limit, limit); }

// Normal equations of at most three unknowns, with the sum of squares left.
struct LeastSquares {
  double ata[3][3] = {}, atb[3] = {}, bb = 0;
  int64_t rows = 0;

  void Add(const std::array<double, 3>& a, double b) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j)
        ata[i][j] += a[static_cast<size_t>(i)] * a[static_cast<size_t>(j)];
      atb[i] += a[static_cast<size_t>(i)] * b;
    }
    bb += b * b;
    ++rows;
  }
  // False when the rows do not tell the unknowns apart.
  bool Solve(std::array<double, 3>& x, std::array<double, 3>& sigma) const {
    dmat3 m;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) m[i][j] = ata[i][j];
    }
    double det = glm::dot(m[0], glm::cross(m[1], m[2]));
    if (!(std::fabs(det) > 1e-12 * m[0][0] * m[1][1] * m[2][2]) || rows <= 3) return false;
    dvec3 rows_of_inverse[3] = {glm::cross(m[1], m[2]) * (1 / det),
                                glm::cross(m[2], m[0]) * (1 / det),
                                glm::cross(m[0], m[1]) * (1 / det)};
    dvec3 b(atb[0], atb[1], atb[2]);
    double left = bb;
    for (size_t i = 0; i < 3; ++i) {
      x[i] = Dot(rows_of_inverse[i], b);
      left -= x[i] * atb[i];
    }
    double variance = std::max(0.0, left) / static_cast<double>(rows - 3);
    for (size_t i = 0; i < 3; ++i) {
      sigma[i] = std::sqrt(std::max(0.0, variance * rows_of_inverse[i][static_cast<int>(i)]));
    }
    return true;
  }
};

// Way of a mass with damping g = b/m under a constant push, for a unit acceleration:
// (g t - 1 + exp(-g t)) / g^2.
double PushedWay(double t_s, double g) {
  if (t_s <= 0) return 0;
  double gt = g * t_s;
  if (gt < 1e-3) return t_s * t_s * (0.5 - gt / 6);
  return (gt - 1 + std::exp(-gt)) / (g * g);
}

}  // namespace

const std::array<Calibrator::Swing, 4> Calibrator::kSwings = {
    {{0.5, 1.0, 3}, {1, 1.0, 4}, {2, 1.0, 6}, {4, 0.6, 8}}};

double PassiveStiffness(double damping_n_s_per_m, double tick_s, const Estimate& delay) noexcept {
  double d = std::max({0.0, std::round(delay.value), delay.value + delay.uncertainty});
  return haptics::CouplingStiffness(damping_n_s_per_m, tick_s, 0) / ((d + 1) * (d + 1));
}

int64_t WholeTicks(const Estimate& delay) noexcept {
  const double upper = delay.value + std::max(0.0, delay.uncertainty);
  return std::max<int64_t>(0, static_cast<int64_t>(std::ceil(upper - kNotRoundedUp_ticks)));
}

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
    if (std::fabs(away) > 2.5 * setup_.reach_m) {
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
  // Lets go in good time, so that the next pulse begins from rest and from no force.
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

// What is left of a push's samples after the best c + a PushedWay(t - t0), per sample squared.
double Calibrator::PushResidual(size_t axis, size_t begin, size_t ticks, double t0_ticks,
                                double g) const {
  double n = 0, sh = 0, sy = 0, shh = 0, shy = 0, syy = 0;
  for (size_t k = 1; k <= ticks; ++k) {
    double h = PushedWay((static_cast<double>(k) - t0_ticks) * setup_.tick_s, g);
    double y = (static_cast<double>(counts_[begin + k][axis]) - counts_[begin][axis]) *
               setup_.count_m[axis];
    n += 1;
    sh += h;
    sy += y;
    shh += h * h;
    shy += h * y;
    syy += y * y;
  }
  double spread = shh - sh * sh / n;
  double left = syy - sy * sy / n;
  if (!(spread > 0)) return left;
  double together = shy - sh * sy / n;
  return left - together * together / spread;
}

// Mean over the pushes of the t0 that leaves least, in ticks after the first sample that could show
// the force (one tick after it was sent). Pushes that moved it too little are left out.
double Calibrator::Delay(size_t axis, double cell_m, double g, Estimate& out) const {
  out = {};
  double sum = 0, squares = 0;
  for (int pulse = 0; pulse < kPulses; ++pulse) {
    auto begin = static_cast<size_t>(pulses_begin_[axis] + pulse * pulse_ticks_);
    size_t ticks = 0;
    while (forces_[begin + ticks][axis] * forces_[begin][axis] > 0) ++ticks;
    double way =
        std::fabs(static_cast<double>(counts_[begin + ticks][axis]) - counts_[begin][axis]);
    if (ticks < 4 || way * setup_.count_m[axis] < kCellsMoved * cell_m) continue;
    double best = 0, least = PushResidual(axis, begin, ticks, 0, g);
    const double latest = static_cast<double>(ticks) - 3;
    for (double t0 = kDelayStep_ticks; t0 < latest; t0 += kDelayStep_ticks) {
      double left = PushResidual(axis, begin, ticks, t0, g);
      if (left < least) {
        least = left;
        best = t0;
      }
    }
    sum += best;
    squares += best * best;
    ++out.samples;
  }
  if (out.samples == 0) return -1;
  auto n = static_cast<double>(out.samples);
  double mean = sum / n;
  double variance = n > 1 ? std::max(0.0, squares / n - mean * mean) * n / (n - 1) : 0.25;
  out.value = mean;
  out.uncertainty = kTwo95 * std::sqrt(variance / n);
  return out.value;
}

Estimate Calibrator::Cell(size_t axis) const {
  std::vector<int32_t> values;
  values.reserve(counts_.size());
  for (const auto& c : counts_) values.push_back(c[axis]);
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  std::vector<double> steps;
  for (size_t i = 1; i < values.size(); ++i) {
    steps.push_back(static_cast<double>(values[i]) - values[i - 1]);
  }
  Estimate out;
  if (steps.empty()) return out;
  std::sort(steps.begin(), steps.end());
  // The tenth smallest of a hundred: cells that were jumped over make longer steps, never shorter.
  double smallest = steps[steps.size() / 10], sum = 0, squares = 0, n = 0;
  for (double s : steps) {
    if (s > 1.5 * smallest) break;
    sum += s;
    squares += s * s;
    n += 1;
  }
  double mean = sum / n;
  double sd = std::sqrt(std::max(0.0, squares / n - mean * mean));
  out.value = mean * setup_.count_m[axis];
  out.uncertainty = kTwo95 * sd / std::sqrt(n) * setup_.count_m[axis];
  out.samples = static_cast<int64_t>(n);
  return out;
}

Estimate Calibrator::Noise(size_t axis, double cell_m) const {
  auto n = static_cast<double>(rest_ticks_);
  double st = 0, sy = 0, stt = 0, sty = 0, syy = 0, first = counts_[0][axis];
  for (int64_t i = 0; i < rest_ticks_; ++i) {
    double t = static_cast<double>(i) - 0.5 * (n - 1);
    double y = counts_[static_cast<size_t>(i)][axis] - first;
    st += t;
    sy += y;
    stt += t * t;
    sty += t * y;
    syy += y * y;
  }
  double left = std::max(0.0, syy - sy * sy / n - sty * sty / stt) / (n - 2);
  double sd_m = std::sqrt(left) * setup_.count_m[axis];
  Estimate out;
  out.samples = rest_ticks_;
  // Below about a third of a cell the counts hardly flicker and say little.
  out.value = std::sqrt(std::max(0.0, sd_m * sd_m - cell_m * cell_m / 12));
  out.uncertainty = out.value > 0.35 * cell_m ? kTwo95 * sd_m / std::sqrt(2 * n) : cell_m / 3;
  return out;
}

// How far apart the places are where it was within twice `ticks` of sample i; `way` is what it went
// from one `ticks` before to one after.
double Calibrator::Range(size_t axis, size_t i, int64_t ticks, double& way_m) const {
  auto at = [&](int64_t offset) {
    auto k = std::clamp<int64_t>(static_cast<int64_t>(i) + offset, 0,
                                 static_cast<int64_t>(counts_.size()) - 1);
    return counts_[static_cast<size_t>(k)][axis] * setup_.count_m[axis];
  };
  way_m = at(ticks) - at(-ticks);
  double low = at(0), high = low;
  for (int64_t quarter = -8; quarter <= 8; ++quarter) {
    double x = at(quarter * ticks / 4);
    low = std::min(low, x);
    high = std::max(high, x);
  }
  return high - low;
}

bool Calibrator::Dynamics(size_t axis, double delay_ticks, double cell_m, AxisFigures& out) const {
  LeastSquares fit;
  double largest = 0;
  auto begin = swings_begin_[axis];
  const auto sign_over =
      static_cast<int64_t>(std::max(1.0, std::round(kSignOver_s / setup_.tick_s)));
  const double still_m = 1.5 * cell_m + 4 * out.noise_m.value;
  for (const Swing& swing : kSwings) {
    double w = 2 * std::numbers::pi * swing.hz;
    auto period = static_cast<int64_t>(std::lround(1 / (swing.hz * setup_.tick_s)));
    for (int p = 0; p < swing.periods; ++p) {
      Complex x = 0, f = 0, s = 0;
      int64_t from = begin + SettleTicks() + p * period;
      for (int64_t k = from; k < from + period; ++k) {
        auto i = static_cast<size_t>(k);
        double t = static_cast<double>(k - from) * setup_.tick_s;
        Complex turn = std::polar(2.0 / static_cast<double>(period), -w * t);
        x += turn * (counts_[i][axis] * setup_.count_m[axis] - home_m_[axis]);
        double way = 0;
        if (Range(axis, i, sign_over, way) <= still_m) continue;  // stuck: friction takes it up
        // Arrives after the bus delay and acts for a tick: its middle is half a tick later.
        f += turn * std::polar(1.0, -w * (delay_ticks + 0.5) * setup_.tick_s) *
             static_cast<double>(forces_[i][axis]);
        if (std::fabs(way) > still_m) s += turn * (way > 0 ? 1.0 : -1.0);
      }
      largest = std::max(largest, std::abs(x));
      Complex inertia = -w * w * x, damping = Complex(0, w) * x;
      fit.Add({inertia.real(), damping.real(), s.real()}, f.real());
      fit.Add({inertia.imag(), damping.imag(), s.imag()}, f.imag());
    }
    begin += TicksOf(swing);
  }
  std::array<double, 3> value, sigma;
  if (largest < 20 * cell_m || !fit.Solve(value, sigma)) return false;
  auto estimate = [&](size_t i) {
    return Estimate{std::max(0.0, value[i]), kTwo95 * sigma[i], fit.rows / 2};
  };
  out.mass_kg = estimate(0);
  out.damping_n_s_per_m = estimate(1);
  out.friction_n = estimate(2);
  return true;
}

Result<std::array<AxisFigures, 3>> Calibrator::Figures() const {
  ENAMEL_CHECK(done());
  if (failed()) return Status(Code::kUnavailable, why_, "device");
  std::array<AxisFigures, 3> out;
  for (size_t i = 0; i < 3; ++i) {
    out[i].resolution_m = Cell(i);
    double cell_m = out[i].resolution_m.value;
    out[i].noise_m = Noise(i, cell_m);
    // The push's form needs b/m, which needs the delay, a little: twice is enough.
    bool moved = cell_m > 0;
    for (int round = 0; moved && round < 3; ++round) {
      double g = round == 0 ? 0 : out[i].damping_n_s_per_m.value / out[i].mass_kg.value;
      double delay = Delay(i, cell_m, g, out[i].delay_ticks);
      moved = delay >= 0 && Dynamics(i, delay, cell_m, out[i]) && out[i].mass_kg.value > 0;
    }
    if (!moved) {
      return Status(Code::kUnavailable,
                    std::string("axis ") + static_cast<char>('x' + i) +
                        " did not move enough under " + std::to_string(setup_.max_force_n) +
                        " N: free it, switch its motors on, or allow more force (--max-force)",
                    "device");
    }
  }
  return out;
}

}  // namespace enamel::station
