#include "common/haptics/count_estimator.h"

namespace enamel::haptics {
namespace {

// Tuning, found with `enamel-lab qualify --suite hand` and `--suite random`.
constexpr double kStraight_cells = 0.4;  // how far a count may lie off the straight line
constexpr double kHistory_s = 0.6;       // nothing older is looked at
constexpr double kDue_cells = 1.2;       // cells' worth of time after which a count is overdue ...
constexpr double kDue_s = 0.005;         // ... and this long
constexpr double kFaded = 0.05;          // less than this of a speed is none
constexpr double kSwing_s = 0.12;

}  // namespace

double FirstGuess(const AxisEstimator (&axes)[3], int axis, double time_s, double delta_m,
                  double tick_s) noexcept {
  double start = 1e9;
  bool others_know = false;
  for (const AxisEstimator& a : axes) {
    if (a.size() > 0) start = LowerOf(start, a.restart_s());
    others_know |= a.size() > 1;
  }
  return axes[axis].FirstGuess(time_s, start, others_know ? 1 : 2, delta_m, tick_s);
}

void TurningAxis::Update(double time_s, double tip_m, double delta_m) noexcept {
  if (tip_m == tip_) return;
  int direction = tip_m > tip_ ? 1 : -1;
  // Tips are cell middles: the edge just crossed is half a cell behind the new middle.
  double edge = tip_m - direction * 0.5 * delta_m;
  tip_ = tip_m;
  if (size_ > 0 && std::fabs(edge - At(0).edge_m) < 0.25 * delta_m) {
    crossed_back_ = direction != direction_;
    crossed_back_s_ = time_s;
    return;
  }
  if (size_ > 0 && direction != direction_) {
    double last_edge = At(0).edge_m;
    size_ = 0;
    if (crossed_back_) Push({crossed_back_s_, last_edge});
    swings_ = time_s - turned_s_ < kSwing_s;
    turned_s_ = time_s;
  }
  crossed_back_ = false;
  direction_ = direction;
  Push({time_s, edge});
  Fit(delta_m);
}

// Least squares through the counts of the longest history in which some line through the newest
// count passes every other within the tolerance. The slopes that do so are an interval that only
// shrinks from count to count, so one pass suffices.
void TurningAxis::Fit(double delta_m) noexcept {
  speed_ = 0;
  if (size_ < 2) return;
  const Event& newest = At(0);
  double lowest = -1e9, highest = 1e9, off = kStraight_cells * delta_m;
  double n = 1, st = 0, sx = 0, stt = 0, stx = 0;
  for (int i = 1; i < size_; ++i) {
    double t = newest.time_s - At(i).time_s, x = newest.edge_m - At(i).edge_m;
    double low = (x - off) / (t + 1e-12), high = (x + off) / (t + 1e-12);
    if (i > 1 && (t > kHistory_s || low > highest || high < lowest)) break;
    lowest = HigherOf(lowest, low);
    highest = LowerOf(highest, high);
    n += 1;
    st += t;
    sx += x;
    stt += t * t;
    stx += t * x;
  }
  double spread = n * stt - st * st;
  if (spread > 0) speed_ = (n * stx - st * sx) / spread;
}

double TurningAxis::Due(double delta_m) const noexcept {
  return kDue_cells * delta_m / (std::fabs(speed_) + 1e-12) + kDue_s;
}

double TurningAxis::Fade(double time_s, double delta_m) const noexcept {
  if (size_ < 2) return 1;
  double f = Due(delta_m) / (time_s - At(0).time_s + 1e-9);
  if (!(f < 1)) return 1;
  f = f * f * f;
  f = f * f;
  return f < kFaded ? 0 : f;
}

}  // namespace enamel::haptics
