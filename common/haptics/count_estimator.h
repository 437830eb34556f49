#pragma once

#include <array>
#include <cmath>

#include "common/math/order.h"
#include "common/math/vec.h"

// Speed of the tip from its encoder's counts. At cutting speed a count comes every 20 to 400 ticks,
// so the times between counts say far more than any difference of positions. Two readings of them:
// AxisEstimator looks back over a window that is given, and is slow and sure; TurningAxis looks back
// only as far as a straight line explains, and follows a hand that turns.
//
// Thread safety: none. Real-time: safe, fixed memory, O(1) but for TurningAxis, which is O(its 32
// events) in a tick with a count. Deterministic: only + - * /.
namespace enamel::haptics {

// Counts closer than this are one event, so that 64 always span the window, s.
inline constexpr double kCountSpacing_s = 0.01;
// A window holds at least this many counts.
inline constexpr int kWindowIntervals = 5;
// Cells' worth of time without a count that is not yet silence. 1.3 lets heavy force hands cycle by
// up to 0.9 N, 1.5 makes the release a tenth longer (`enamel-lab qualify --suite random`).
inline constexpr double kSilenceCounts = 1.4;
// Nor is this many times the longest of the last gaps between counts.
inline constexpr double kSilenceGaps = 1.03;

// Time, encoder edge and anchor at which one axis made a count.
struct CountEvent {
  double time_s, edge_m, anchor_m;
};

// Tip velocity of one axis from its count events. An event is the crossing of an edge other than
// the one crossed last, so that dithering on one edge is silence. Fixed memory: 64 events.
class AxisEstimator {
 public:
  void Reset(double tip_m) noexcept {
    tip_ = tip_m;
    size_ = 0;
    has_edge_ = false;
    restart_s_ = -1;
  }

  // Whether the axis made a count.
  bool Update(double time_s, double tip_m, double anchor_m, double delta_m) noexcept {
    if (tip_m == tip_) return false;
    // Tips are cell middles: the edge just crossed is half a cell behind the new middle.
    double edge = tip_m > tip_ ? tip_m - 0.5 * delta_m : tip_m + 0.5 * delta_m;
    sign_ = tip_m > tip_ ? 1 : -1;
    tip_ = tip_m;
    if (has_edge_ && std::fabs(edge - last().edge_m) < 0.25 * delta_m) return false;
    if (size_ == 0) restart_s_ = time_s;
    stale_ = true;
    if (size_ > 2 && time_s - At(1).time_s < kCountSpacing_s) {
      events_[static_cast<size_t>((head_ - 1 + kEvents) % kEvents)] = {time_s, edge, anchor_m};
    } else {
      Push({time_s, edge, anchor_m});
    }
    return true;
  }

  // Mean speed over the window that ends at the newest event, before any silence. Requires: two
  // events. `ends` counts are averaged at each end of the window (1 or 2, the same in every call).
  // Why 2: Coulomb friction lets a tip make its counts in pairs (8 ms apart, then none for 43). A
  // window from one event to one event ends behind a pair and may begin inside one, and then holds a
  // count too many: 1 to 5 % of the speed, never too few. Ends averaged over a pair lie on the line.
  double Mean(double window_s, int ends = 1) noexcept {
    Refresh(window_s, ends);
    return mean_m_per_s_;
  }
  // The anchor's mean speed over the same window.
  double AnchorMean(double window_s, int ends = 1) noexcept {
    Refresh(window_s, ends);
    return anchor_mean_m_per_s_;
  }
  // After one count only bounds are known: it came at most kappa cells of travel ago, and since the
  // motion began at start_s the axis has moved about `cells`.
  double FirstGuess(double time_s, double start_s, double cells, double delta_m,
                    double tick_s) const noexcept {
    double recent = kSilenceCounts * delta_m / (SinceLast(time_s) + tick_s);
    double started = cells * delta_m / (time_s - start_s + tick_s);
    return sign_ * LowerOf(recent, started);
  }

  // The tip rests: what was counted before says nothing about the next motion.
  void Rest() noexcept { size_ = 0; }

  double SinceLast(double time_s) const noexcept {
    return size_ == 0 ? 1e9 : time_s - last().time_s;
  }
  int size() const noexcept { return size_; }
  double restart_s() const noexcept { return restart_s_; }

 private:
  static constexpr int kEvents = 64;

  void Refresh(double window_s, int ends) noexcept {
    if (!stale_ && window_s == window_s_) return;
    stale_ = false;
    window_s_ = window_s;
    // The shortest look back that satisfies both bounds, found from the last one: O(1) per count.
    const CountEvent& newest = At(0);
    auto Enough = [&](int back) {
      return newest.time_s - At(back).time_s >= window_s && back >= kWindowIntervals;
    };
    back_ = back_ < 1 ? 1 : back_ > size_ - 1 ? size_ - 1 : back_;
    while (back_ > 1 && Enough(back_ - 1)) --back_;
    while (back_ + 1 < size_ && !Enough(back_)) ++back_;
    const CountEvent& oldest = At(back_);
    double span = newest.time_s - oldest.time_s, way = newest.edge_m - oldest.edge_m,
           anchor_way = newest.anchor_m - oldest.anchor_m;
    if (ends > 1 && back_ >= 4 && back_ + 2 <= size_) {
      const CountEvent &late = At(1), &early = At(back_ + 1);
      span += late.time_s - early.time_s;
      way += late.edge_m - early.edge_m;
      anchor_way += late.anchor_m - early.anchor_m;
    }
    mean_m_per_s_ = span > 0 ? way / span : 0;
    anchor_mean_m_per_s_ = span > 0 ? anchor_way / span : 0;
  }
  const CountEvent& At(int back) const noexcept {
    return events_[static_cast<size_t>((head_ - 1 - back + 2 * kEvents) % kEvents)];
  }
  const CountEvent& last() const noexcept { return At(0); }
  void Push(const CountEvent& e) noexcept {
    events_[static_cast<size_t>(head_)] = e;
    head_ = (head_ + 1) % kEvents;
    if (size_ < kEvents) ++size_;
    has_edge_ = true;
  }

  std::array<CountEvent, kEvents> events_{};
  int head_ = 0, size_ = 0, back_ = 1;
  double tip_ = 0, restart_s_ = -1, sign_ = 0;
  double mean_m_per_s_ = 0, anchor_mean_m_per_s_ = 0, window_s_ = -1;
  bool has_edge_ = false, stale_ = true;
};

// The last gaps between counts of whichever axis: on an oblique way the tip counts more often than
// its fastest axis, and so betrays a stop sooner.
class GapRecord {
 public:
  void Clear() noexcept {
    size_ = 0;
    last_s_ = -1;
  }
  void Count(double time_s) noexcept {
    if (last_s_ >= 0) {
      gaps_[static_cast<size_t>(at_)] = time_s - last_s_;
      at_ = (at_ + 1) % kGaps;
      if (size_ < kGaps) ++size_;
      longest_s_ = 0;
      for (double gap : gaps_) longest_s_ = gap > longest_s_ ? gap : longest_s_;
    }
    last_s_ = time_s;
  }
  // A time without a count that is not yet silence, at most `quiet_s`.
  double Quiet(double quiet_s) const noexcept {
    return size_ < kGaps ? quiet_s : LowerOf(quiet_s, kSilenceGaps * longest_s_);
  }

 private:
  static constexpr int kGaps = 8;
  std::array<double, kGaps> gaps_{};
  int at_ = 0, size_ = 0;
  double last_s_ = -1, longest_s_ = 0;
};

// Speed of an axis after its first count (AxisEstimator::FirstGuess), m/s: the motion began when the
// first of the three counted, and while others made more counts this one has moved by one cell.
double FirstGuess(const AxisEstimator (&axes)[3], int axis, double time_s, double delta_m,
                  double tick_s) noexcept;
// Time without a count that is not yet silence at this speed, s.
inline double QuietTime(double delta_m, double speed_m_per_s) noexcept {
  return kSilenceCounts * delta_m / (speed_m_per_s + 1e-12);
}
// What is left of a speed after `since_s` without a count: 1 up to quiet_s, then falling with the sixth
// power of the time.
inline double SilenceFade(double quiet_s, double since_s) noexcept {
  double f = quiet_s / (since_s + 1e-9);
  if (!(f < 1)) return 1;
  double cube = f * f * f;
  return cube * cube;
}

// Speed of one axis for a hand that turns back and forth: the longest history that a straight line
// through the newest count explains within a part of a cell. Crossing the last edge back again may
// be a tip dithering on it; only the next edge confirms that the hand has turned, and the time of
// the first crossing is then already part of the new history.
class TurningAxis {
 public:
  void Reset(double tip_m) noexcept {
    tip_ = tip_m;
    turned_s_ = -1e9;
    swings_ = false;
    Rest();
  }
  // The tip rests: what was counted before says nothing about the next motion.
  void Rest() noexcept {
    size_ = 0;
    direction_ = 0;
    crossed_back_ = false;
    speed_ = 0;
  }
  void Update(double time_s, double tip_m, double delta_m) noexcept;
  // Speed over the history that ends at the newest count, m/s; 0 with fewer than two counts.
  double speed() const noexcept { return speed_; }
  // Time since the newest count, s; 1e9 without one. Due: within which the next is expected at that speed, s.
  double SinceLast(double time_s) const noexcept {
    return size_ == 0 ? 1e9 : time_s - At(0).time_s;
  }
  double Due(double delta_m) const noexcept;
  // What is left of that speed when no count has come since: 1 while the next is not yet due, then
  // falling with the sixth power of the time, 0 below a twentieth.
  double Fade(double time_s, double delta_m) const noexcept;
  // Whether the axis has turned twice, a cell or more each time, within 0.12 s: hands do not, a
  // soft hand's mass on the coupling's spring does. Reading it forgets it.
  bool TakeSwing() noexcept {
    bool swings = swings_;
    swings_ = false;
    return swings;
  }

 private:
  static constexpr int kEvents = 32;
  struct Event {
    double time_s, edge_m;
  };
  const Event& At(int back) const noexcept {
    return events_[static_cast<size_t>((head_ - 1 - back + 2 * kEvents) % kEvents)];
  }
  void Push(const Event& e) noexcept {
    events_[static_cast<size_t>(head_)] = e;
    head_ = (head_ + 1) % kEvents;
    if (size_ < kEvents) ++size_;
  }
  void Fit(double delta_m) noexcept;

  std::array<Event, kEvents> events_{};
  int head_ = 0, size_ = 0, direction_ = 0;
  bool crossed_back_ = false, swings_ = false;
  double tip_ = 0, crossed_back_s_ = 0, turned_s_ = -1e9, speed_ = 0;
};

}  // namespace enamel::haptics
