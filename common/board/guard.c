#include "common/board/guard.h"

#include <math.h>

#include "common/board/vec.h"

// 0 for what is negative or not a number.
static double NotNegative(double v) { return v > 0 ? v : 0; }

double EnSupport(const EnCell* cell, EnVec w) {
  double s = cell->half_m.x * fabs(w.x) + cell->half_m.y * fabs(w.y) + cell->half_m.z * fabs(w.z);
  if (cell->ball_m > 0) s += cell->ball_m * sqrt(EnDot(w, w));
  return s + fabs(EnDot(cell->joint_half_m[0], w)) + fabs(EnDot(cell->joint_half_m[1], w)) +
         fabs(EnDot(cell->joint_half_m[2], w));
}

double EnRadius(const EnCell* cell) {
  // The farthest corner of a parallelepiped is one of four (and their opposites); seen from the
  // corner, the box adds its own corner on that side.
  double farthest2 = 0;
  for (int signs = 0; signs < 4; ++signs) {
    EnVec corner = cell->joint_half_m[0];
    corner = EnPlus(corner, EnTimes(cell->joint_half_m[1], signs & 1 ? -1 : 1));
    corner = EnPlus(corner, EnTimes(cell->joint_half_m[2], signs & 2 ? -1 : 1));
    const EnVec far = {fabs(corner.x) + cell->half_m.x, fabs(corner.y) + cell->half_m.y,
                       fabs(corner.z) + cell->half_m.z};
    const double far2 = EnDot(far, far);
    if (far2 > farthest2) farthest2 = far2;
  }
  return sqrt(farthest2) + cell->ball_m;
}

void EnBeginTick(EnTank* tank) {
  const EnVec none = {0, 0, 0};
  tank->admitted_j = 0;
  tank->moved_m = none;
}

double EnGuardedStep(const EnGuard* guard, EnVec e, EnVec w, double work, EnTank* tank) {
  const double kc = guard->kc_n_per_m;
  const double w2 = EnDot(w, w);
  if (!(w2 > 0) || !isfinite(w2)) return 0;
  if (kc == 0) return 1;  // no spring, no energy
  // The worst tip in the cell gains Kc (s Q - beta s^2 w^2) less than V + E allows.
  double q = EnDot(e, w) - EnSupport(&guard->cell, w);
  double beta = 0.5;
  if (guard->delay_ticks > 0) {
    // Forces under way do not know of the move. What they may give back is paid for by another
    // weight / 2 of |total move of the tick|^2: this step's part of it.
    q -= guard->delay_weight * EnDot(tank->moved_m, w);
    beta = 0.5 + 0.5 * guard->delay_weight;
  }
  if (!(kc > 0) || !isfinite(q) || !(beta >= 0.5)) return 0;
  double energy = NotNegative(tank->energy_j);
  const double budget = energy / kc;
  double s = 1;
  if (q - beta * w2 + budget < 0) {
    const double root = sqrt(q * q + 4 * beta * w2 * budget);
    if (!isfinite(root)) return 0;
    // The same root twice: no difference of nearly equal numbers.
    s = q > 0 ? (q + root) / (2 * beta * w2) : 2 * budget / (root - q);
    if (!(s > 0)) return 0;
    if (s > 1) s = 1;
  }
  const double drop = kc * (s * q - beta * s * s * w2);
  if (drop > 0) {
    const double room = NotNegative(tank->inflow_share * work - tank->admitted_j);
    double in = drop < room ? drop : room;
    if (energy + in > tank->cap_j) in = NotNegative(tank->cap_j - energy);
    tank->admitted_j += in;
    energy += in;
  } else {
    energy += drop;
  }
  tank->energy_j = NotNegative(energy);
  tank->moved_m = EnPlus(tank->moved_m, EnTimes(w, s));
  return s;
}

double EnStiffnessShare(const EnGuard* guard, EnVec e, double bound, double before, EnTank* tank) {
  const double length = sqrt(EnDot(e, e));
  const double force = guard->kc_n_per_m * length;
  if (!isfinite(force) || !isfinite(bound)) return 0;
  const double wanted = force > bound ? NotNegative(bound) / force : 1;
  if (!(wanted > before)) return wanted;
  const double farthest = length + EnRadius(&guard->cell);
  // V at full stiffness, at most.
  const double whole = 0.5 * guard->kc_n_per_m * farthest * farthest;
  const double cost = (wanted - before) * whole, energy = NotNegative(tank->energy_j);
  if (cost <= energy) {
    tank->energy_j = energy - cost;
    return wanted;
  }
  tank->energy_j = 0;
  return before + energy / whole;
}

double EnResumedShare(const EnGuard* guard, EnVec e, double kept, EnTank* tank) {
  const EnVec none = {0, 0, 0};
  const double energy = NotNegative(tank->energy_j);
  tank->energy_j = energy + NotNegative(kept);
  const double share = EnGuardedStep(guard, none, EnTimes(e, -1), 0, tank);
  if (tank->energy_j > energy) tank->energy_j = energy;
  return share;
}
