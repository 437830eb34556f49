#include "common/haptics/gated_mobility.h"

#include <cmath>

#include "common/haptics/count_estimator.h"
#include "common/haptics/coupling.h"

namespace enamel::haptics {
namespace {

// Tuning, found with `enamel-lab qualify --suite random`; dimensionless.
constexpr double kOpeningSlope = 5;  // how fast a gate opens above r = 1
constexpr double kStillGate = 0.1;
constexpr double kStillCells = 1.05;  // "within the cell": this many half cells ...
constexpr double kStillRamp = 0.5;    // ... and fully outside this many later
constexpr double kSlowCells = 1;  // an axis whose target force is below this many Kc delta is slow
constexpr double kSlowReach = 1.02;  // its cross stretch beyond this many half cells is let go

double Opened(double r, double cap) noexcept {
  double g = 1 + kOpeningSlope * (r - 1);
  return g < cap ? g : cap;
}

}  // namespace

double GateAlong(double r, double cap) noexcept {
  return r < 1 ? (r * r) * (r * r) : Opened(r, cap);
}

double GateAcross(double r, double cap) noexcept { return r <= 1 ? 1 : Opened(r, cap); }

double StillGate(const dvec3& across, const dvec3& resolution) noexcept {
  double cells = 0;
  for (int i = 0; i < 3; ++i) {
    double q = 2 * std::fabs(across[i]) / resolution[i];
    cells = q > cells ? q : cells;
  }
  double share = (cells - kStillCells) / kStillRamp;
  share = share < 0 ? 0 : share > 1 ? 1 : share;
  return kStillGate + (1 - kStillGate) * share;
}

dvec3 RelaxedStretch(const Sym3& b, double mean_b, const dvec3& v, double power, double along,
                     double across, double s, const dvec3& e) noexcept {
  // Without the rank-one part: (I + s g A)^-1 = B (B + s g I)^-1 (B regularised).
  double shift = s * across;
  auto base = [&](const dvec3& x) {
    dvec3 y = SolveShifted(b, shift + kFreeDamping * mean_b, x);
    return b * y + y * (kFreeDamping * mean_b);
  };
  dvec3 e0 = base(e);
  if (power == 0) return e0;
  // Sherman-Morrison for the rank-one part; base is symmetric.
  double c = s * (along - across) / power;
  dvec3 v0 = base(v);
  return e0 - v0 * (c * Dot(v, e0) / (1 + c * Dot(v, v0)));
}

void TurnToward(const dvec3& bv, double k, dvec3& e) noexcept {
  double length = std::sqrt(Dot(e, e)), norm = std::sqrt(Dot(bv, bv));
  if (!(length > 0) || !(norm > 0)) return;
  dvec3 u = bv / norm;
  if (!(Dot(u, e) > 0)) return;
  e += (u * length - e) * k;
}

void DropSlowAxes(const dvec3& bv, const dvec3& along, double kc, const dvec3& resolution,
                  dvec3& e) noexcept {
  dvec3 across = e - along;
  for (int i = 0; i < 3; ++i) {
    double half = 0.5 * resolution[i];
    if (std::fabs(bv[i]) > kSlowCells * 2 * half * kc) continue;
    double excess = std::fabs(across[i]) - kSlowReach * half;
    if (!(excess > 0) || excess > half || !(across[i] * e[i] > 0)) continue;
    double take = LowerOf(excess, std::fabs(e[i]));
    e[i] -= e[i] > 0 ? take : -take;
  }
}

dvec3 SpendBeforeGuard(const dvec3& e, const dvec3& relaxed, const dvec3& resolution) noexcept {
  dvec3 w = e - relaxed;
  double factor = GuardFactor(e, w, resolution);
  if (factor >= 1) return relaxed;
  dvec3 apart(0);
  for (int i = 0; i < 3; ++i) {
    double reach = std::fabs(e[i]) - 0.5 * resolution[i];
    double want = e[i] > 0 ? w[i] : -w[i];
    if (!(reach > 0) || !(want > 0)) continue;
    double take = want < reach ? want : reach;
    apart[i] = e[i] > 0 ? take : -take;
  }
  return Dot(apart, e) > factor * Dot(w, e) ? e - apart : relaxed;
}

}  // namespace enamel::haptics
