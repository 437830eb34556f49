#pragma once

#include "common/board/report.h"
#include "common/board/spring.h"

// Reference firmware of a haptic board that runs the coupling's spring: it takes the host's output
// reports, gives the motors' force in each tick of its own fast loop, and fills in what the spring
// reports. schemas/hid_haptic_report.md has the rules, "Lost host" among them. A maker adds what
// the hardware needs: encoders, motors, USB, torque.
//
// C11, no heap, no libc but <math.h>, about a hundred doubles of state. SI units, board axes, zero
// as of the counts.
//
// Why it is safe whatever the host does: the rest point moves by guarded steps only, so that the
// proof of common/haptics/README.md holds for any reports at any time, and the force is at most
// `peak_n`. Not covered: the added force and the cell, which are the host's word.
//
// No wish changes the force at once. In a tick of length T the spring's force R changes by at most
//
//   |R_k - R_(k-1)| <= Kc (|p_k - p_(k-1)| + 2 S) + EN_RISE_N_PER_S T,     N
//
// p the reading, S the radius of EnBoardParams::cell. The hand's own motion changes R by Kc times
// the way even if the rest point stays, two readings of one place differ by up to 2 S, and the last
// term lets a hand at rest reach any wish. A step of the rest point that would exceed this is
// shortened, which the guard's proof always allows. Faster is only the way to 0: R shrinks along
// itself at once when the bound or the share falls, and is 0 when spring or motors are off. The added
// force changes by at most EN_ADDED_N_PER_S T, also to 0 when the host is lost. It yields at once
// where the spring needs the peak, and is 0 when spring or motors are off.
//
// Thread safety: none; call all of it from the loop, or with interrupts off. Real-time safe: bounded
// work, some hundred floating-point operations a tick.
#ifdef __cplusplus
extern "C" {
#endif

// Why these times: schemas/hid_haptic_report.md, "Lost host". At 3 ms three reports are missing;
// what falls within half a second is gone well within the second that is asked for.
#define EN_LOST_S 3e-3
#define EN_FALL_S 0.5
#define EN_OFF_S 3.0

// The last term of that bound, N/s: what a host always has, even if its operator holds still. The
// cell's 2 Kc S a tick comes on top, so 100 matters only on a board with very fine counts.
#define EN_RISE_N_PER_S 100.0
// The added force's bound, N/s. Touch cues of 0.3 N on contact and 0.12 N of chatter change by up to 0.38 N
// from one report to the next (touch_cues.h): at 8 kHz these pass in one tick, as if unbounded.
#define EN_ADDED_N_PER_S 4000.0

typedef struct EnBoardParams {
  double tick_s;      // T of the fast loop
  int delay_ticks;    // d: whole ticks of it from reading the encoders to the force that answers
  double kc_n_per_m;  // Kc
  EnCell cell;        // of the counts, wherever the tip is
  double peak_n;      // most of the force
  double damping_n_s_per_m;  // b, measured: what the proof asks for is checked at the start
} EnBoardParams;

// What the host asks for; as in output report 0x47, in SI units.
typedef struct EnCommand {
  bool motors_on, spring_on, follow;
  EnVec rest_m;
  EnVec added_n;
  double share, bound_n;
  EnCell cell;  // no size: the board's own
} EnCommand;

typedef struct EnBoard {
  EnBoardParams params;
  EnSpring spring;
  EnCommand command;
  uint32_t sequence;
  bool heard;       // since the start, or since the host was lost
  double silent_s;  // since the last report that counted
  double last_n;    // the spring's force when it came
  double slack_n;   // of a tick's bound on the change of the force: what the reading does not add
  bool running;     // the spring, in the last tick
  EnVec tip_m;      // of the last tick
  EnVec felt_n;     // the spring's force of the last tick
  EnVec added_n;    // what of the host's force was added to it
  double work_j;    // of the operator on the spring
  int flags;        // of the spring's last pull
} EnBoard;

// Largest Kc that damping b pays for, 2 b/((d + 1)^2 T), N/m.
double EnLargestKc(double damping_n_s_per_m, double tick_s, int delay_ticks);

// Off, tank empty. False, and the board stays without force, if a number is not positive (the
// delay: negative) or Kc is above EnLargestKc.
bool EnBoardStart(EnBoard* board, const EnBoardParams* params);

// Any bytes that came as an output report. True if the report counts. A force report (0x46) turns
// the spring off, and its force is the caller's to drive.
bool EnBoardReceive(EnBoard* board, const uint8_t* bytes, size_t size);
// The same for another bus: a command with its number. What is not finite does not count.
bool EnBoardObey(EnBoard* board, const EnCommand* command, uint32_t sequence);

// One tick of the fast loop at this reading: the force on the operator, N. 0 and off when the
// reading is not finite.
EnVec EnBoardTick(EnBoard* board, EnVec tip_m);

// The motors are to be driven.
bool EnBoardDrives(const EnBoard* board);

// Writes the spring's fields of the input report.
void EnBoardTell(const EnBoard* board, EnPoseReport* report);

#ifdef __cplusplus
}
#endif
