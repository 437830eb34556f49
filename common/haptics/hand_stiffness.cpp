#include "common/haptics/hand_stiffness.h"

#include <cmath>

namespace enamel::haptics {
namespace {

// Tuning, found with `enamel-lab qualify --suite hand` and `--suite random`.
constexpr double kRecent_s = 0.03;    // longer than a quarter swing of 0.5 kg on 2.5 N/mm, 23 ms
constexpr double kTelling_cells = 4;  // a smaller move of the rest point tells nothing
constexpr double kFollowed = 0.4;     // share of the move that the tip of a soft hand makes too
constexpr double kShortest_s = 0.5, kLongest_s = 30;  // of the hold after a loss
constexpr double kForgiven_s = 1;  // full trust for this long: a third of the hold is enough
constexpr double kRise_s = 0.2;    // from 0 to 1: a soft hand shows itself at a small share
constexpr double kPersistent_s = 0.12;
constexpr int kPersistentCounts = 4;
constexpr double kSwinging_s = 0.3;

}  // namespace

void HandStiffness::Reset() noexcept {
  *this = HandStiffness();
  backoff_s_ = kShortest_s;
}

void HandStiffness::Step(const Tick& tick, double cell_m, double tick_s) noexcept {
  counted_ = tick.counted;
  swung_s_ = tick.swings ? kSwinging_s : swung_s_ - tick_s;
  double keep = 1 / (1 + tick_s / kRecent_s);
  moved_recently_ = (moved_recently_ + moved_) * keep;
  moved_ = dvec3(0);
  tip_surprise_ = (tip_surprise_ + tick.tip_moved_m - tick.slow_speed_m_per_s * tick_s) * keep;
  double moved2 = Dot(moved_recently_, moved_recently_), telling = kTelling_cells * cell_m;
  bool followed =
      moved2 > telling * telling && Dot(tip_surprise_, moved_recently_) > kFollowed * moved2;
  if (followed || tick.swings) {
    if (trust_ > 0) backoff_s_ = 2 * backoff_s_ < kLongest_s ? 2 * backoff_s_ : kLongest_s;
    hold_s_ = backoff_s_;
    trust_ = 0;
    return;
  }
  if (hold_s_ > 0) {
    hold_s_ -= tick_s;
    return;
  }
  bool persistent =
      off_s_ * kShortest_s > kPersistent_s * backoff_s_ && off_counts_ >= kPersistentCounts;
  if (!(trust_ > 0) && !persistent) return;
  trust_ += tick_s / kRise_s;
  if (trust_ < 1) return;
  trust_ = 1;
  double less = backoff_s_ - backoff_s_ * tick_s / kForgiven_s;
  backoff_s_ = less > kShortest_s ? less : kShortest_s;
}

void HandStiffness::Off(const dvec3& off_m, bool beyond, double tick_s) noexcept {
  bool same_side = beyond && Dot(off_m, off_) > 0;
  off_s_ = same_side ? off_s_ + tick_s : 0;
  off_counts_ = same_side ? off_counts_ + (counted_ ? 1 : 0) : 0;
  off_ = off_m;
}

void HandStiffness::VisitState(StateArchive& archive) {
  archive(trust_, hold_s_, backoff_s_, off_s_, swung_s_, off_counts_, counted_, off_, moved_,
          moved_recently_, tip_surprise_);
}

}  // namespace enamel::haptics
