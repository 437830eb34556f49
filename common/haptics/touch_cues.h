#pragma once

#include <array>

#include "common/base/check.h"
#include "common/base/state_archive.h"
#include "common/math/trig.h"
#include "common/math/vec.h"

// Touch cues: small forces beside the coupling's that signal contact and the turning bur.
//  * A knock when the bur meets tissue: one damped oscillation against the way it came,
//      c = -u A r^n sin(2 pi f n T), n = 1, 2, ... ticks, r = D / (D + T).
//    On real surfaces the tool rings like this, stronger the faster it came (Okamura, Cutkosky and
//    Dennerlein, IEEE/ASME Trans. Mechatronics 6(3), 2001: A proportional to the speed, f and decay
//    of the material). Short transients at contact make virtual surfaces feel hard (Kuchenbecker,
//    Fiene and Niemeyer, IEEE TVCG 12(2), 2006). Here A = contact_n min(1, v / 20 mm/s), nothing
//    below a cell per 20 ms, f from 60 Hz (soft) to 230 Hz (hard), D = 1.5 periods.
//  * Chatter while the bur cuts: an oscillation across its axis, amplitude
//      chatter_n R / (R + 1 N) * h, h = B / (B + 1 N s/mm): load R, hardness h of the tissue.
//    A turbine turns at up to 400 000 /min = 6.7 kHz: far above what a 1 kHz loop can send or a
//    hand can feel. Its 40th part is sent (167 Hz at 400 000 /min), so that the pitch falls with
//    the speed as the handpiece bogs down, held between 60 Hz and 230 Hz or a fifth of the loop's
//    rate. A hand around a tool feels 150 to 200 Hz best (Brisben, Hsiao and Johnson, J.
//    Neurophysiology 81, 1999), and five values a period keep the wave's images above the loop's
//    half rate. A rate under 300 Hz leaves no band: then there are no cues.
// The shapes and the constants are choices: published is that such waves help, not these figures.
//
// Energy. Cues are outside the coupling's proof, so they have one of their own (README.md, "Touch
// cues"): whatever the hand does, the work it draws from them never exceeds energy_j + power_w t
// plus X, and X is 0 while no axis of the tip accelerates by more than kFastest_m_per_s2.
//
// SI units, scene frame, forces on the operator. Thread safety: none, one loop owns it. Real-time:
// all but construction and VisitState (fixed memory, O(delay)). Deterministic: + - * / sqrt.
namespace enamel::haptics {

struct CueAccountParams {
  double energy_j = 0;  // given at once, at most
  double power_w = 0;   // added with time
  double tick_s = 0.001;
  dvec3 cell_half_m{0};  // |x_i - p_i| at most: half a cell, more with noise or a turned lattice
  int delay_ticks = 0;   // whole ticks from reading to force, at most
};

// Bounds the energy of cues. Once per tick, with the tip just read and the cue wanted: returns the
// share of the cue that the account can pay in the worst case, and books what the last tick may
// have cost.
class CueAccount {
 public:
  static constexpr double kFastest_m_per_s2 = 100;
  static constexpr int kMaxDelay = 16;

  // Requires: 0 <= delay_ticks <= kMaxDelay.
  explicit CueAccount(const CueAccountParams& params);

  // The tip's way since the last call is that of the tick in between. The result is `wanted_n`
  // times a share in [0, 1]; send exactly this result, in this tick. 0 in the first tick: the tip's
  // speed is not known.
  ENAMEL_REALTIME dvec3 Afford(const dvec3& tip_m, const dvec3& wanted_n) noexcept;
  // Instead of the tick's booking, before Afford: force stopped unseen since the last call (lost
  // ticks, a fault). What that may have cost is paid, and nothing is left.
  void Gap(const dvec3& tip_m) noexcept;

  // Below 0: debt, and no cue until it is paid.
  double balance_j() const noexcept { return balance_j_; }
  void VisitState(StateArchive& archive) { archive(balance_j_, tip_, moved_, sent_, started_); }

 private:
  void Book(const dvec3& moved_m) noexcept;
  double Share(const dvec3& wanted_n) const noexcept;

  CueAccountParams params_;
  double balance_j_;
  dvec3 tip_{0}, moved_{0};
  std::array<dvec3, kMaxDelay + 1> sent_{};  // newest first; the first delay_ticks + 1 count
  bool started_ = false;
};

struct TouchCueParams {
  double contact_n = 0, chatter_n = 0;  // largest force of each; 0: none
  double peak_force_n = 0;              // coupling and cue together never exceed it
  CueAccountParams account;
};

// A tick as the cues see it.
struct TouchCueInput {
  dvec3 tip_m{0};                 // measured
  dvec3 coupling_n{0};            // the coupling's force as it will be sent
  dvec3 pressed_n{0};             // and as the hand feels it, the device's own friction among it
  dvec3 across{1, 0, 0};          // unit, across the bur's axis
  double tissue_b_n_s_per_m = 0;  // B of the tissue touched, as of its reference engagement
  double bur_speed_krpm = 0;      // 0: still
  bool contact_read = false;      // whether `engaged` was looked at; else as in the last tick
  bool engaged = false;           // the bur has tissue ahead
  bool suspended = false;         // no force at all: everything that was under way ends
  bool bounded = false;           // a bound has changed the coupling's force: no cue in this tick
  bool gap = false;               // CueAccount::Gap
};

class TouchCues {
 public:
  explicit TouchCues(const TouchCueParams& params);

  // Whether there can ever be a cue. Where not, Tick need not be called.
  bool enabled() const noexcept { return enabled_; }
  // Force to add to the coupling's, N. Once per tick.
  ENAMEL_REALTIME dvec3 Tick(const TouchCueInput& input) noexcept;
  double balance_j() const noexcept { return account_.balance_j(); }
  // Saves or restores all that the next Tick depends on but the parameters. Not real-time.
  void VisitState(StateArchive& archive);

  // Frequencies of the two, Hz, and amplitude shares (header comment).
  double KnockFrequency_hz(double tissue_b_n_s_per_m) const noexcept;
  double ChatterFrequency_hz(double bur_speed_krpm) const noexcept;
  static double Hardness(double tissue_b_n_s_per_m) noexcept;

 private:
  void NoteMotion(const dvec3& tip_m) noexcept;
  void NoteContact(const TouchCueInput& input) noexcept;
  void StartKnock(double tissue_b_n_s_per_m) noexcept;
  dvec3 Knock() noexcept;
  dvec3 Chatter(const TouchCueInput& input) noexcept;
  dvec3 WithinPeak(const dvec3& coupling_n, const dvec3& cue_n) const noexcept;

  TouchCueParams params_;
  CueAccount account_;
  double highest_hz_;
  bool enabled_;
  dvec3 tip_{0}, velocity_{0};  // velocity: smoothed over kSmooth_s
  bool started_ = false, engaged_ = false;
  double free_s_ = 1e9;  // since tissue was ahead
  // The knock: direction times amplitude left, phase as a unit vector, its turn and decay per tick.
  dvec3 knock_n_{0};
  double knock_cos_ = 1, knock_sin_ = 0, turn_cos_ = 1, turn_sin_ = 0, decay_ = 0;
  double chatter_cos_ = 1, chatter_sin_ = 0;
  double chatter_turns_ = 0;  // a tick, and its sine and cosine
  SinCos chatter_turn_;
};

}  // namespace enamel::haptics
