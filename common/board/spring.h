#pragma once

#include "common/board/guard.h"

// The coupling's spring: a rest point that moves by guarded steps only, the tank that pays for
// them, and the share of the stiffness that is felt. The core runs it once a tick, or a board's
// firmware some thousand times a second, so that the spring may be stiffer (guard.h: Kc goes with
// 1/T).
//
// SI units, one frame for all vectors. Thread safety: none, one loop owns it. Real-time safe.
#ifdef __cplusplus
extern "C" {
#endif

typedef struct EnSpring {
  EnGuard guard;  // with all of the stiffness; the steps are guarded at what is felt of it
  EnTank tank;
  EnVec rest_m;
  double share;
} EnSpring;

// What a pull did.
enum {
  kEnGuarded = 1,  // the guard shortened a step
  kEnBounded = 2,  // the bound held the force down
};

typedef struct EnForce {
  EnVec whole_n;  // on the operator, with all of the stiffness
  EnVec felt_n;   // with the share that is felt; within the bound
  int flags;      // kEnGuarded | kEnBounded
} EnForce;

// At rest at the tip, all of the stiffness: a new count of the energy begins, V_0 <= Kc/2
// EnRadius^2. The tank keeps what is in it.
void EnSpringReset(EnSpring* spring, EnVec tip_m);

// After ticks without force: keeps of the stretch what the tank pays for (EnResumedShare). Begins a
// tick of the tank.
void EnSpringResume(EnSpring* spring, EnVec tip_m);

// One tick, after EnBeginTick: draws the rest point to `wish_m` as far as the guard lets it, lets
// it give way to the bound, and feels the rest of the bound as a share of the stiffness, at most
// `most_share`. What is not finite moves nothing.
EnForce EnSpringPull(EnSpring* spring, EnVec tip_m, EnVec wish_m, double bound_n,
                     double most_share);

#ifdef __cplusplus
}
#endif
