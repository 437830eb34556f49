#pragma once

#include "common/math/sym3.h"
#include "common/math/vec.h"

// The pieces of the gated Maxwell laws that only take from the stretch e: what a gate is, and how e
// relaxes under a gated mobility. Notation as in force_law.h; mean_b = tr B / 3.
//
// All functions: pure, real-time safe, deterministic (+ - * / sqrt).
namespace enamel::haptics {

// B is often singular (a flat face resists one direction only): the free directions get a mobility
// this many times smaller than the mean damping's inverse, which is as good as free in one tick.
inline constexpr double kFreeDamping = 1e-6;

// Gate along the hand's motion at r = R / (B v): r^4 below 1 holds the anchor back while the force
// is below what the speed calls for; above 1 it opens linearly up to `cap`.
double GateAlong(double r, double cap) noexcept;
// Gate across it: closed never, open where the cross force is beyond its share (r > 1).
double GateAcross(double r, double cap) noexcept;
// Gate across while the cross stretch is within the encoder's own cell, where it is most likely not
// there: left nearly alone, the counts of a slow axis swing it half a cell to both sides of nothing.
double StillGate(const dvec3& across_m, const dvec3& resolution_m) noexcept;

// (I + s M)^-1 e with M = across A + (along - across) v v^T / (v^T B v), A = B^-1 and s = Kc dt. M is
// symmetric and positive semi-definite, so this is P e with P = P^T, 0 <= P <= I. `power` is v^T B v,
// 0: no motion known, `across` everywhere.
dvec3 RelaxedStretch(const Sym3& b, double mean_b, const dvec3& v, double power, double along,
                     double across, double s, const dvec3& e_m) noexcept;
// With anisotropic B the direction of e settles only at B/Kc; turning it toward B v keeps its length
// from growing. k is the share of the way turned.
void TurnToward(const dvec3& bv, double k, dvec3& e_m) noexcept;
// An axis the hand hardly moves along makes a count now and then, which would show as a whole Kc
// delta: what is more than half a cell off is let go at once. `along_m` is the part of e along B v.
void DropSlowAxes(const dvec3& bv, const dvec3& along_m, double kc_n_per_m,
                  const dvec3& resolution_m, dvec3& e_m) noexcept;
// Where the guard would shorten the step from e to `relaxed` (it stalls once |e|^2 < delta/2 sum
// |e_i|), each axis may still come to within half a cell of the tip: w_i <= |e_i| - delta_i/2 passes
// the guard whole, since e.w - sum delta_i |w_i| / 2 >= w.w. Takes whichever step frees more energy.
dvec3 SpendBeforeGuard(const dvec3& e_m, const dvec3& relaxed_m,
                       const dvec3& resolution_m) noexcept;

}  // namespace enamel::haptics
