#include "common/board/spring.h"

#include <math.h>

#include "common/board/vec.h"

// The only place but reset and resume where the rest point moves. All that the spring surely loses
// flows into the tank: the work of the tick does not bound it.
static const double kNoBound_j = 1e9;

static int Move(EnSpring* s, EnVec tip, EnVec w) {
  if (EnDot(w, w) == 0) return 0;
  EnGuard felt = s->guard;
  felt.kc_n_per_m *= s->share;
  const double share = EnGuardedStep(&felt, EnMinus(tip, s->rest_m), w, kNoBound_j, &s->tank);
  s->rest_m = EnPlus(s->rest_m, EnTimes(w, share));
  return share < 1 ? kEnGuarded : 0;
}

void EnSpringReset(EnSpring* s, EnVec tip) {
  s->rest_m = tip;
  s->share = 1;
}

void EnSpringResume(EnSpring* s, EnVec tip) {
  const EnVec stretch = EnMinus(tip, s->rest_m);
  EnGuard felt = s->guard;
  felt.kc_n_per_m *= s->share;
  EnBeginTick(&s->tank);
  s->rest_m = EnMinus(tip, EnTimes(stretch, EnResumedShare(&felt, stretch, 0, &s->tank)));
}

EnForce EnSpringPull(EnSpring* s, EnVec tip, EnVec wish, double bound, double most_share) {
  EnForce out;
  const double kc = s->guard.kc_n_per_m;
  out.flags = Move(s, tip, EnMinus(wish, s->rest_m));
  EnVec e = EnMinus(tip, s->rest_m);
  out.whole_n = EnTimes(e, -kc);
  const double held = kc * sqrt(EnDot(e, e));
  if (held > bound) {
    out.flags |= kEnBounded | Move(s, tip, EnTimes(e, 1 - bound / held));
    e = EnMinus(tip, s->rest_m);
  }
  if (most_share < 1) {
    const double most = most_share * kc * sqrt(EnDot(e, e));
    if (most < bound) bound = most;
  }
  s->share = EnStiffnessShare(&s->guard, e, bound, s->share, &s->tank);
  out.felt_n = EnTimes(e, -kc * s->share);
  return out;
}
