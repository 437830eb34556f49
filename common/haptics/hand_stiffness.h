#pragma once

#include "common/base/state_archive.h"
#include "common/math/vec.h"

// How stiff the hand on the tool is beside the coupling's spring, judged while it works.
//
// Why it matters. A hand that prescribes its motion needs the force set to B v at once: it cannot
// swing. For a hand that prescribes its force the rest point makes the speed. A law that sets the
// force from the speed it sees then closes a loop through its own delay, and cycles. Real hands are
// in between (0.2 to 1 N/mm beside a Kc of 2.5 to 10). To distinguish the two, move the rest point:
// a stiff hand shows it in the stretch, a soft one in the tip.
//
// Trust runs from 0 (soft, or not known) to 1 (stiff). It is lost at once, for a hold that doubles
// with each loss (0.5 to 30 s), in two cases: the tip follows what the law did to the rest point
// (more than 0.4 of it, over 30 ms, once that is beyond 4 cells), or it swings
// (TurningAxis::TakeSwing). It is given where the stretch has long been off what the speed calls
// for (0.12 s and 4 counts on the same side, longer after losses). In a soft hand it is never off,
// because there the force makes the speed.
//
// Thread safety: none. Real-time: safe. Deterministic: + - * / sqrt.
namespace enamel::haptics {

class HandStiffness {
 public:
  struct Tick {
    dvec3 tip_moved_m{0};         // since the last tick
    dvec3 slow_speed_m_per_s{0};  // the hand's, as far as it was known before any doubt
    bool counted = false;         // some axis made a count
    bool swings = false;          // some axis swings
  };
  void Reset() noexcept;
  // Once per tick, before Off and Moved. `cell_m`: the encoder's.
  void Step(const Tick& tick, double cell_m, double tick_s) noexcept;
  // How far the stretch is off what the fast speed calls for; `beyond`: by more than a steady cut
  // in a soft hand is.
  void Off(const dvec3& off_m, bool beyond, double tick_s) noexcept;
  // What the law moved the rest point by for the hand's sake in this tick.
  void Moved(const dvec3& rest_m) noexcept { moved_ = rest_m; }

  double trust() const noexcept { return trust_; }
  // Whether some axis swung in the last 0.3 s: tremor, or a mass on the spring.
  bool swinging() const noexcept { return swung_s_ > 0; }
  void VisitState(StateArchive& archive);

 private:
  double trust_ = 0, hold_s_ = 0, backoff_s_ = 0, off_s_ = 0, swung_s_ = 0;
  int off_counts_ = 0;
  bool counted_ = false;
  dvec3 off_{0}, moved_{0}, moved_recently_{0}, tip_surprise_{0};
};

}  // namespace enamel::haptics
