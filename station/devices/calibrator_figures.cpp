// Evaluates the motion that calibrator.cpp made. Times are in ticks of the loop. Fits find their
// unknowns by least squares in closed form; only nonlinear ones are searched (the start of a push,
// the frequency of a mode).
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <set>

#include "common/haptics/criteria.h"
#include "station/devices/calibrator.h"

namespace enamel::station {
namespace {

using Complex = std::complex<double>;

constexpr double kSignOver_s = 0.010;
constexpr double kDelayStep_ticks = 0.02, kBefore_ticks = 1;
// Resolution of a push's start: the quantised first ticks, a damped mode.
constexpr double kModelDelay_ticks = 0.1, kModeDelay_ticks = 0.3;
constexpr double kFewPushes95 = 2.36;            // Student's t of eight pushes
constexpr double kExplained = 1.2, kUm2 = 1e12;  // um^2 in a m^2
// Range of a first structural mode (above, it is no slower than the push's first ticks), and the
// share of the residual that a fit with it must stay below to be believed.
constexpr double kLowestMode_hz = 25, kHighestMode_hz = 250, kModeEarns = 0.8;
// The search's steps, and those in which the best mode is refined.
constexpr double kModeStep = 1.15, kModeFineStep = 1.01;
// What damping and the tip's share of the mass, which the fit does not know, may move the mode's frequency by.
constexpr double kModeShare = 0.1;
constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kTwo95 = 1.96;
constexpr double kNotRoundedUp_ticks = 0.25;
// Possible errors of the swings' model: a share of each figure, more for friction (when noise hides
// the reversal), and a moment's phase, which makes damping look like mass.
constexpr double kModelShare = 0.01, kFrictionShare = 0.03, kPhase_s = 0.4e-3;
constexpr size_t kAloneTicks = 3, kFewMoves = 40;
constexpr size_t kFewPlaces = 20, kManyPlaces = 2000;
constexpr double kBlockShare = 0.1;
constexpr double kCellsMoved = 4;  // by a push, before its way says anything

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
  // Sum of squares left by the best of the first two unknowns, and of all three if `third` is set
  // and the third is not negative.
  double Left(bool third) const {
    const double det2 = ata[0][0] * ata[1][1] - ata[0][1] * ata[0][1];
    if (!(det2 > 0)) return bb;
    auto project = [&](double u, double v) {  // of the normal equations' right side (u, v)
      return dvec3((ata[1][1] * u - ata[0][1] * v) / det2, (ata[0][0] * v - ata[0][1] * u) / det2,
                   0);
    };
    const dvec3 y = project(atb[0], atb[1]), h = project(ata[0][2], ata[1][2]);
    const double left = bb - y.x * atb[0] - y.y * atb[1];
    if (!third) return left;
    const double own = ata[2][2] - h.x * ata[0][2] - h.y * ata[1][2];
    const double with = atb[2] - y.x * ata[0][2] - y.y * ata[1][2];
    // Along the push's own direction, whatever its sign.
    const double a = y.y, r = with / own;
    return own > 1e-9 * ata[2][2] && r * a > 0 ? left - with * with / own : left;
  }
  // False when the rows do not determine the unknowns.
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
// Jackknife: figures with one reading left out each.
struct LeftOut {
  double sum = 0, squares = 0, n = 0;
  void Add(double value) {
    sum += value;
    squares += value * value;
    ++n;
  }
  double Variance() const { return std::max(0.0, squares - sum * sum / n) * (n - 1) / n; }
};

// (g t - 1 + exp(-g t)) / g^2.
double PushedWay(double t_s, double g) {
  if (t_s <= 0) return 0;
  double gt = g * t_s;
  if (gt < 1e-3) return t_s * t_s * (0.5 - gt / 6);
  return (gt - 1 + std::exp(-gt)) / (g * g);
}

}  // namespace

double PassiveStiffness(double damping_n_s_per_m, double tick_s, const Estimate& delay) noexcept {
  double d = std::max(0.0, delay.value + delay.uncertainty);
  return haptics::CouplingStiffness(damping_n_s_per_m, tick_s, 0) / ((d + 1) * (d + 1));
}

int64_t WholeTicks(const Estimate& delay) noexcept {
  const double upper = delay.value + std::max(0.0, delay.uncertainty);
  return std::max<int64_t>(0, static_cast<int64_t>(std::ceil(upper - kNotRoundedUp_ticks)));
}

// Residual of a push's samples after the best c + a PushedWay(t - t0) + r (1 - cos w (t - t0)), r
// >= 0. A structural mode lets the motor's side run ahead at first, and a fit without it takes that
// for an earlier start. w = 0: a rigid device.
double Calibrator::PushResidual(size_t axis, const Push& push, double t0_ticks, double g,
                                double w) const {
  LeastSquares fit;
  const double scale = 1e6;  // um, so that the unknowns are alike
  for (size_t k = 1; k <= push.ticks; ++k) {
    const double t = std::max(0.0, (static_cast<double>(k) - t0_ticks) * setup_.tick_s);
    double y = (static_cast<double>(counts_[push.begin + k][axis]) - counts_[push.begin][axis]) *
               setup_.count_m[axis] * scale;
    fit.Add({1, PushedWay(t, g) * scale, w > 0 ? 1 - std::cos(w * t) : 0}, y);
  }
  return fit.Left(w > 0);
}

// The t0 with the least residual over all these pushes except `without`, in ticks after the first
// sample that could show the force (one tick after it was sent), with the best mode.
double Calibrator::Beginning(size_t axis, const std::vector<Push>& pushes, size_t without, double g,
                             double variance_m2, double& w) const {
  auto left = [&](double t0, double mode) {
    double sum = 0;
    for (size_t i = 0; i < pushes.size(); ++i) {
      if (i != without) sum += PushResidual(axis, pushes[i], t0, g, mode);
    }
    return sum;
  };
  auto latest = [&] {
    size_t shortest = pushes.front().ticks;
    for (const Push& p : pushes) shortest = std::min(shortest, p.ticks);
    return static_cast<double>(shortest) - 4;
  }();
  auto best_at = [&](double mode, double& least) {
    double best = 0;
    least = left(0, mode);
    auto look = [&](double from, double to, double step) {
      for (double t0 = from; t0 <= to; t0 += step) {
        double l = left(t0, mode);
        if (l < least) {
          least = l;
          best = t0;
        }
      }
    };
    look(-kBefore_ticks, latest, 0.25);
    look(best - 0.25, best + 0.25, kDelayStep_ticks);
    return best;
  };
  double least = 0;
  if (w >= 0) return best_at(w, least);
  double best = best_at(0, least);
  w = 0;
  // Where a rigid device explains the motion to the encoder's accuracy, a mode would only fit the
  // encoder's steps; elsewhere it has to justify its two unknowns.
  const double rigid = least;
  double samples = 0;
  for (const Push& p : pushes) samples += static_cast<double>(p.ticks);
  if (rigid < kExplained * samples * variance_m2 * kUm2) return best;
  for (double hz = kLowestMode_hz; hz < 0.25 / setup_.tick_s && hz <= kHighestMode_hz;
       hz *= kModeStep) {
    double l = 0, at = best_at(kTurn * hz, l);
    if (l < least && l < kModeEarns * rigid) {
      least = l;
      best = at;
      w = kTurn * hz;
    }
  }
  return best;
}

// The mode within a step of the search above that leaves the least residual, at this start.
double Calibrator::NearestMode(size_t axis, const std::vector<Push>& pushes, size_t without,
                               double g, double t0, double w) const {
  double best = w, least = std::numeric_limits<double>::infinity();
  for (double at = w / kModeStep; at <= w * kModeStep; at *= kModeFineStep) {
    double sum = 0;
    for (size_t i = 0; i < pushes.size(); ++i) {
      if (i != without) sum += PushResidual(axis, pushes[i], t0, g, at);
    }
    if (sum < least) {
      least = sum;
      best = at;
    }
  }
  return best;
}

// Leaves out pushes with too little motion. The intervals are from leaving out one push at a time.
double Calibrator::Delay(size_t axis, double cell_m, double noise_m, double g,
                         AxisFigures& figures) const {
  Estimate& out = figures.delay_ticks;
  out = figures.mode_hz = {};
  const double variance_m2 = cell_m * cell_m / 12 + noise_m * noise_m;
  std::vector<Push> pushes;
  for (int pulse = 0; pulse < kPulses; ++pulse) {
    Push push{static_cast<size_t>(pulses_begin_[axis] + pulse * pulse_ticks_), 0};
    while (forces_[push.begin + push.ticks][axis] * forces_[push.begin][axis] > 0) ++push.ticks;
    double way = std::fabs(static_cast<double>(counts_[push.begin + push.ticks][axis]) -
                           counts_[push.begin][axis]);
    if (push.ticks < 6 || way * setup_.count_m[axis] < kCellsMoved * cell_m) continue;
    pushes.push_back(push);
  }
  out.samples = static_cast<int64_t>(pushes.size());
  if (pushes.empty()) return -1;
  double w = -1;
  const double value = Beginning(axis, pushes, pushes.size(), g, variance_m2, w);
  LeftOut delay, mode;
  for (size_t i = 0; pushes.size() > 1 && i < pushes.size(); ++i) {
    delay.Add(Beginning(axis, pushes, i, g, variance_m2, w));
    if (w > 0) mode.Add(NearestMode(axis, pushes, i, g, value, w));
  }
  out.value = std::max(0.0, value);
  out.uncertainty = kFewPushes95 * std::sqrt(delay.n > 1 ? delay.Variance() : 0.25) +
                    (w > 0 ? kModeDelay_ticks : kModelDelay_ticks);
  if (w > 0) {
    const double hz = NearestMode(axis, pushes, pushes.size(), g, value, w) / kTurn;
    figures.mode_hz = {
        hz,
        kFewPushes95 * std::sqrt(mode.n > 1 ? mode.Variance() : hz * hz) / kTurn + kModeShare * hz,
        out.samples};
  }
  return out.value;
}

// One axis' steps between neighbouring values of all counts.
Estimate Calibrator::StepOf(size_t axis) const {
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
  // The tenth smallest of a hundred: skipped cells make steps longer, never shorter.
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

// The moves between samples that are as long as one joint's count: their length is the joint's
// cell, whatever the arm's pose makes of it along x, y and z. None when moves are along one axis at
// a time, as for cells along the axes.
Estimate Calibrator::JointCell() const {
  std::vector<double> alone, all;
  size_t oblique = 0, straight = 0;
  auto move = [&](size_t i) {
    dvec3 m(0);
    for (size_t k = 0; k < 3; ++k) {
      m[static_cast<int>(k)] =
          (static_cast<double>(counts_[i][k]) - counts_[i - 1][k]) * setup_.count_m[k];
    }
    return m;
  };
  size_t last = 0;
  for (size_t i = 1; i < counts_.size(); ++i) {
    if (counts_[i] == counts_[i - 1]) continue;
    all.push_back(glm::length(move(i)));
    bool quiet = i > last + kAloneTicks && i + kAloneTicks < counts_.size();
    last = i;
    for (size_t k = i; quiet && k < i + kAloneTicks; ++k) quiet = counts_[k] == counts_[k + 1];
    if (quiet) alone.push_back(all.back());
  }
  Estimate out;
  if (all.size() < kFewMoves) return out;
  // If noise leaves no single moves, the shortest of all.
  const bool few = alone.size() < kFewMoves;
  std::vector<double>& lengths = few ? all : alone;
  std::sort(lengths.begin(), lengths.end());
  double middle = few ? lengths[std::max<size_t>(kFewMoves, lengths.size() / 200)]
                      : lengths[lengths.size() / 2];
  double sum = 0, squares = 0, n = 0;
  for (int round = 0; round < (few ? 8 : 1); ++round) {
    sum = squares = n = 0;
    for (double l : lengths) {
      if (l < (few ? 0.7 : 0.4) * middle || l > (few ? 1.2 : 1.3) * middle) continue;
      sum += l * l;
      squares += l * l * l * l;
      n += 1;
    }
    if (few) middle = std::sqrt(sum / n);
  }
  const double low = 0.4 * middle, high = 1.3 * middle;
  for (size_t i = 1; i < counts_.size(); ++i) {
    const dvec3 m = move(i);
    const double l = glm::length(m);
    if (l < low || l > high) continue;
    const double largest = std::max({std::fabs(m.x), std::fabs(m.y), std::fabs(m.z)});
    ++(largest < 0.995 * l ? oblique : straight);
  }
  if (oblique < straight / 3) return out;
  // A driver that rounds the position to cells r makes a move longer: r^2/2 in the mean square.
  double rounded = middle;
  for (size_t axis = 0; axis < 3; ++axis) rounded = std::min(rounded, StepOf(axis).value);
  const double square = sum / n, sd = std::sqrt(std::max(0.0, squares / n - square * square));
  const double cell = std::sqrt(std::max(square - rounded * rounded / 2, 0.25 * square));
  out.value = std::max(cell, rounded);
  out.uncertainty = kTwo95 * sd / std::sqrt(n) / (2 * out.value) +
                    rounded * rounded / out.value / 4 + kModelShare * out.value;
  out.samples = static_cast<int64_t>(n);
  if (few) {
    if (const Estimate still = RestingCell(rounded); still.samples > 0) return still;
    out.uncertainty += rounded * rounded / out.value / 4;
  }
  return out;
}

// The places that noise of whole counts shows at rest form a block of the joints' lattice: n of
// them, n^(1/3) along each joint, have a spread of (n^(2/3) - 1) delta^2 / 12 along each.
Estimate Calibrator::RestingCell(double rounded_m) const {
  std::set<std::array<int32_t, 3>> places(counts_.begin(), counts_.begin() + rest_ticks_);
  Estimate out;
  if (places.size() < kFewPlaces || places.size() > kManyPlaces) return out;
  dvec3 sum(0), squares(0);
  for (const auto& place : places) {
    for (size_t k = 0; k < 3; ++k) {
      double x = (static_cast<double>(place[k]) - counts_[0][k]) * setup_.count_m[k];
      sum[static_cast<int>(k)] += x;
      squares[static_cast<int>(k)] += x * x;
    }
  }
  const auto n = static_cast<double>(places.size());
  double spread = (squares.x + squares.y + squares.z) / n - Dot(sum, sum) / (n * n);
  spread -= rounded_m * rounded_m / 4;  // a twelfth along each axis
  out.value = std::sqrt(std::max(rounded_m * rounded_m, 4 * spread / (std::cbrt(n * n) - 1)));
  out.uncertainty = kBlockShare * out.value;  // a block that is not quite full
  out.samples = static_cast<int64_t>(places.size());
  return out;
}

Estimate Calibrator::Cell(size_t axis) const {
  const Estimate joint = JointCell();
  return joint.samples > 0 ? joint : StepOf(axis);
}

// Residual at rest after a straight line (an arm creeps under its own weight), less the share of
// rounding to cells, cell^2 / 12.
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
  // Below about a third of a cell the counts hardly flicker and give little information.
  out.value = std::sqrt(std::max(0.0, sd_m * sd_m - cell_m * cell_m / 12));
  out.uncertainty = out.value > 0.35 * cell_m ? kTwo95 * sd_m / std::sqrt(2 * n) : cell_m / 3;
  return out;
}

// Range of positions within twice `ticks` of sample i; `way` is the distance from one `ticks`
// before to one after.
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

// m x'' + b x' + F sign(x') = f, fitted to the first harmonic of each period. The part that repeats
// with the swing stays, the encoder's steps and noise at other frequencies drop out, and no
// derivative of counts is taken. While the device is stuck the force does not depend on its motion,
// so those samples are left out on both sides.
bool Calibrator::Dynamics(size_t axis, double delay_ticks, double cell_m, AxisFigures& out) const {
  // One fit of all swings, and one without each: the model's errors show between speeds, not within
  // one.
  LeastSquares fit;
  std::array<LeastSquares, kSwingCount> without;
  double largest = 0;
  auto begin = swings_begin_[axis];
  const auto sign_over =
      static_cast<int64_t>(std::max(1.0, std::round(kSignOver_s / setup_.tick_s)));
  const double still_m = 1.5 * cell_m + 4 * out.noise_m.value;
  for (size_t index = 0; index < kSwings.size(); ++index) {
    const Swing& swing = kSwings[index];
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
      auto add = [&](LeastSquares& to) {
        to.Add({inertia.real(), damping.real(), s.real()}, f.real());
        to.Add({inertia.imag(), damping.imag(), s.imag()}, f.imag());
      };
      add(fit);
      for (size_t other = 0; other < without.size(); ++other) {
        if (other != index) add(without[other]);
      }
    }
    begin += TicksOf(swing);
  }
  std::array<double, 3> value, sigma;
  if (largest < 20 * cell_m || !fit.Solve(value, sigma)) return false;
  std::array<double, 3> between{};
  for (const LeastSquares& some : without) {
    std::array<double, 3> v, unused;
    if (!some.Solve(v, unused)) return false;
    for (size_t i = 0; i < 3; ++i) between[i] += (v[i] - value[i]) * (v[i] - value[i]);
  }
  auto estimate = [&](size_t i) {
    constexpr double n = kSwingCount;
    const double spread = std::sqrt(between[i] * (n - 1) / n);
    return Estimate{std::max(0.0, value[i]),
                    kTwo95 * std::sqrt(sigma[i] * sigma[i] + spread * spread) +
                        kModelShare * std::fabs(value[i]),
                    fit.rows / 2};
  };
  out.mass_kg = estimate(0);
  out.damping_n_s_per_m = estimate(1);
  out.friction_n = estimate(2);
  out.mass_kg.uncertainty += kPhase_s * out.damping_n_s_per_m.value;
  out.friction_n.uncertainty += kFrictionShare * out.friction_n.value;
  return true;
}

Result<std::array<AxisFigures, 3>> Calibrator::Figures() const {
  ENAMEL_CHECK(done());
  if (failed()) return Status(Code::kUnavailable, why_, "device");
  std::array<AxisFigures, 3> out;
  const bool joints = JointCell().samples > 0;
  for (size_t i = 0; i < 3; ++i) {
    out[i].joints = joints;
    out[i].count_m = setup_.count_m[i];
    out[i].resolution_m = Cell(i);
    double cell_m = out[i].resolution_m.value;
    out[i].noise_m = Noise(i, cell_m);
    // The push's formula needs b/m, which depends slightly on the delay: two rounds are enough.
    bool moved = cell_m > 0;
    for (int round = 0; moved && round < 3; ++round) {
      double g = round == 0 ? 0 : out[i].damping_n_s_per_m.value / out[i].mass_kg.value;
      double delay = Delay(i, cell_m, out[i].noise_m.value, g, out[i]);
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
