#pragma once

// The guard: how far the rest point of the coupling's spring may move in one step so that the
// operator can never draw more energy than is there. With a tank, what the operator has already
// lost may pay for a step that raises the spring's energy. The proof is in
// common/haptics/README.md, "Why it is passive"; its symbols: x true tip, p measured tip, r rest
// point, e = p - r, R = Kc e, V = Kc/2 |x - r|^2, E energy in the tank, T tick, b and c the
// device's own damping and Coulomb friction, d whole ticks from reading to force.
//
// Claim: V + E never rises in a guarded step, wherever in its cell the tip is, so with
// Kc <= 2 b / ((d + 1)^2 T) and c >= Kc times the cell's support the sum of
// R.dx + (b/T) |dx|^2 + sum c_i |dx_i| never falls under -(V_0 + E_0), whatever the hand, the
// tissue and the law do.
//
// C11, so that the firmware of a board and the core run the same lines: no heap, no state but the
// tank given, doubles, only + - * / sqrt. SI units, one frame for all vectors, any thread,
// real-time safe. What is not finite moves nothing and leaves the tank alone.
#ifdef __cplusplus
extern "C" {
#endif

typedef struct EnVec {
  double x, y, z;
} EnVec;

// Where the true tip can be around the measured one: the sum of a box along the axes, a ball and a
// parallelepiped of the half edges joint_half_m, all centred on p. Whatever noise or lattice a
// device has, the proof needs only |u.(x - p)| <= EnSupport(u) at every tick, so a cell may turn
// and stretch with the pose.
typedef struct EnCell {
  EnVec half_m;
  double ball_m;
  EnVec joint_half_m[3];
} EnCell;

// Largest |w.(x - p)|, m |w|; largest |x - p|, m.
double EnSupport(const EnCell* cell, EnVec w);
double EnRadius(const EnCell* cell);

// Energy that may pay for raising the spring's. E_0, what it starts with, is part of the floor:
// declare it, grant it once, never again on a reset.
typedef struct EnTank {
  double energy_j;
  double cap_j;         // nothing flows in above it
  double inflow_share;  // of the operator's work in a tick
  // Of this tick: what has flown in, J, and how far the rest point has moved, m. Cleared by
  // EnBeginTick, which must be called once before the first step of every tick: with delay the
  // proof needs it, without delay a tank that is not told only fills less.
  double admitted_j;
  EnVec moved_m;
} EnTank;

void EnBeginTick(EnTank* tank);

typedef struct EnGuard {
  double kc_n_per_m;  // of the spring as it is felt: Kc times EnStiffnessShare
  EnCell cell;
  int delay_ticks;  // upper end of what was measured; a delay that varies below it is covered
  // With delay: how much of a move's square, beside V's own half, is kept for the forces under way,
  // as halves (above 0). 1 lets the rest point reach the tip in one step and needs
  // Kc <= 2 b / ((d + 1)^2 T); more shortens steps to 2/(1 + weight) and needs only
  // Kc <= 2 b / ((1 + 2 d + d^2/weight) T).
  double delay_weight;
} EnGuard;

// Largest s in [0, 1] such that moving the rest point by s w cannot raise V + E (with delay: nor
// what the forces still under way may give back); updates the tank. The caller moves the rest point
// by s w. work_j: the operator's measured work R.dx since the last tick, the same for every step of
// a tick; together they let in at most its share. It bounds the inflow only, so an error in it is
// harmless: what flows in never exceeds the drop of V that is certain.
double EnGuardedStep(const EnGuard* guard, EnVec e_m, EnVec w_m, double work_j, EnTank* tank);

// Share k in [0, 1] of the stiffness with which the spring may be felt, so that the sent force
// k Kc e stays within bound_n: for what is left of a bound after the rest point has given way as
// far as the guard lets it (a bound under Kc EnRadius). A share falls freely and rises as far as
// the tank pays; at 0 with an empty tank it stays there until a reset. share_before: last tick's, 1
// after a reset. The proof covers it without delay; with delay a fall gives back at most Kc |e| per
// metre of the next d ticks.
double EnStiffnessShare(const EnGuard* guard, EnVec e_m, double bound_n, double share_before,
                        EnTank* tank);

// After ticks in which no force was sent: share s in [0, 1] of the stretch with which the spring
// may continue, rest point at p - s e, so that it costs no more than a reset (which starts a new
// count with V_0 <= Kc/2 EnRadius^2). It is a reset and a guarded step back that the tank pays.
// kept_j pays first: what surely was in the spring when the force stopped. It is 0 when the tip
// moved unseen, as between the last reading and the stop: it may have taken all. With delay: only
// once the forces under way have ended, after EnBeginTick and in the same tick as the steps that
// follow.
double EnResumedShare(const EnGuard* guard, EnVec e_m, double kept_j, EnTank* tank);

#ifdef __cplusplus
}
#endif
