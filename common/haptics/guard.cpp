#include "common/haptics/guard.h"

#include "common/math/order.h"

namespace enamel::haptics {
namespace {

// 0 for what is negative or not a number.
double NotNegative(double v) noexcept { return v > 0 ? v : 0; }

}  // namespace

double TipCell::Radius() const noexcept {
  // The farthest corner of a parallelepiped is one of four (and their opposites); seen from the
  // corner, the box adds its own corner on that side.
  double farthest2 = 0;
  for (int signs = 0; signs < 4; ++signs) {
    dvec3 corner = joint_half_m[0];
    corner += signs & 1 ? -joint_half_m[1] : joint_half_m[1];
    corner += signs & 2 ? -joint_half_m[2] : joint_half_m[2];
    dvec3 far(std::fabs(corner.x) + half_m.x, std::fabs(corner.y) + half_m.y,
              std::fabs(corner.z) + half_m.z);
    farthest2 = HigherOf(farthest2, Dot(far, far));
  }
  return std::sqrt(farthest2) + ball_m;
}

dvec3 TipCell::Friction(double kc) const noexcept {
  dvec3 c;
  for (int i = 0; i < 3; ++i) {
    c[i] = kc * (half_m[i] + ball_m + std::fabs(joint_half_m[0][i]) +
                 std::fabs(joint_half_m[1][i]) + std::fabs(joint_half_m[2][i]));
  }
  return c;
}

TipCell CartesianCell(const dvec3& delta, double counts) noexcept {
  TipCell cell;
  cell.half_m = delta * (0.5 + counts);
  return cell;
}

TipCell LatticeCell(double delta, double rounding, double counts) noexcept {
  TipCell cell;
  cell.half_m = dvec3(0.5 * rounding);
  cell.ball_m = std::sqrt(3.0) * delta * (0.5 + counts);
  return cell;
}

double GuardedStep(const GuardParams& params, const dvec3& e, const dvec3& w, double work,
                   Tank& tank) noexcept {
  double kc = params.kc_n_per_m;
  double w2 = Dot(w, w);
  if (!(w2 > 0) || !std::isfinite(w2)) return 0;
  if (kc == 0) return 1;  // no spring, no energy
  // The worst tip in the cell gains Kc (s Q - beta s^2 w^2) less than V + E allows.
  double q = Dot(e, w) - params.cell.Support(w);
  double beta = 0.5;
  if (params.delay_ticks > 0) {
    // Forces under way do not know of the move. What they may give back is paid for by another
    // weight / 2 of |total move of the tick|^2: this step's part of it.
    q -= params.delay_weight * Dot(tank.moved_m, w);
    beta = 0.5 + 0.5 * params.delay_weight;
  }
  if (!(kc > 0) || !std::isfinite(q) || !(beta >= 0.5)) return 0;
  double energy = NotNegative(tank.energy_j);
  double budget = energy / kc;
  double s = 1;
  if (q - beta * w2 + budget < 0) {
    double root = std::sqrt(q * q + 4 * beta * w2 * budget);
    if (!std::isfinite(root)) return 0;
    // The same root twice: no difference of nearly equal numbers.
    s = q > 0 ? (q + root) / (2 * beta * w2) : 2 * budget / (root - q);
    if (!(s > 0)) return 0;
    if (s > 1) s = 1;
  }
  double drop = kc * (s * q - beta * s * s * w2);
  if (drop > 0) {
    double room = NotNegative(tank.inflow_share * work - tank.admitted_j);
    double in = drop < room ? drop : room;
    if (energy + in > tank.cap_j) in = NotNegative(tank.cap_j - energy);
    tank.admitted_j += in;
    energy += in;
  } else {
    energy += drop;
  }
  tank.energy_j = NotNegative(energy);
  tank.moved_m += w * s;
  return s;
}

double StiffnessShare(const GuardParams& params, const dvec3& e, double bound, double before,
                      Tank& tank) noexcept {
  double force = params.kc_n_per_m * std::sqrt(Dot(e, e));
  if (!std::isfinite(force) || !std::isfinite(bound)) return 0;
  double wanted = force > bound ? NotNegative(bound) / force : 1;
  if (!(wanted > before)) return wanted;
  double farthest = std::sqrt(Dot(e, e)) + params.cell.Radius();
  double whole = 0.5 * params.kc_n_per_m * farthest * farthest;  // V at full stiffness, at most
  double cost = (wanted - before) * whole, energy = NotNegative(tank.energy_j);
  if (cost <= energy) {
    tank.energy_j = energy - cost;
    return wanted;
  }
  tank.energy_j = 0;
  return before + energy / whole;
}

double ResumedShare(const GuardParams& params, const dvec3& e, double kept, Tank& tank) noexcept {
  double energy = NotNegative(tank.energy_j);
  tank.energy_j = energy + NotNegative(kept);
  double share = GuardedStep(params, dvec3(0), -e, 0, tank);
  if (tank.energy_j > energy) tank.energy_j = energy;
  return share;
}

}  // namespace enamel::haptics
