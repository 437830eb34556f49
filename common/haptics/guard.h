#pragma once

#include <bit>

#include "common/base/check.h"
#include "common/board/guard.h"
#include "common/math/vec.h"

// The guard of common/board/guard.h with the core's vectors: there is one implementation, in C, which a
// board's firmware shares. Meaning, units and proof of each member and function are there.
// All functions: world frame, SI units, any thread (no state but the Tank given), real-time safe.
namespace enamel::haptics {

inline EnVec ToBoard(const dvec3& v) noexcept { return {v.x, v.y, v.z}; }
inline dvec3 FromBoard(const EnVec& v) noexcept { return {v.x, v.y, v.z}; }

// EnCell.
struct TipCell {
  dvec3 half_m{0};    // half cell per axis (the driver's rounding); n counts of noise add n delta
  double ball_m = 0;  // radius of a ball that holds any joint lattice's cell; 0: Cartesian device
  // Columns J_j dq_j/2: half edges of the cell of joint encoders at this pose. Zero: unused.
  dmat3 joint_half_m{0.0};

  EnCell board() const noexcept { return std::bit_cast<EnCell>(*this); }
  double Support(const dvec3& w) const noexcept {
    const EnCell cell = board();
    return EnSupport(&cell, ToBoard(w));
  }
  // Largest |x - p|, m.
  double Radius() const noexcept {
    const EnCell cell = board();
    return EnRadius(&cell);
  }
  // Least Coulomb friction per axis of space, N, that pays for what the cell hides. A device whose
  // friction acts along other (orthonormal) axes, such as joints, needs Kc Radius() on each.
  dvec3 Friction(double kc_n_per_m) const noexcept;
};

// Cell of an encoder of resolution delta along the axes of space, with noise of `counts` counts.
TipCell CartesianCell(const dvec3& resolution_m, double counts = 0) noexcept;
// Cell of a cubic lattice of edge delta turned any way, with a driver that rounds the result again
// to `rounding_m` (0: it does not) and noise of `counts` joint counts.
TipCell LatticeCell(double resolution_m, double rounding_m, double counts = 0) noexcept;

// EnTank.
struct Tank {
  double energy_j = 0;
  double cap_j = 0;
  double inflow_share = 0.05;
  double admitted_j = 0;
  dvec3 moved_m{0};

  void BeginTick() noexcept {
    admitted_j = 0;
    moved_m = dvec3(0);
  }
};

// EnGuard.
struct GuardParams {
  double kc_n_per_m = 0;
  TipCell cell{};
  int delay_ticks = 0;
  double delay_weight = 1;

  EnGuard board() const noexcept { return {kc_n_per_m, cell.board(), delay_ticks, delay_weight}; }
};

// `call(guard, tank)` with both as the C functions want them.
template <typename Call>
ENAMEL_REALTIME double OnBoard(const GuardParams& params, Tank& tank, Call call) noexcept {
  const EnGuard guard = params.board();
  auto board = std::bit_cast<EnTank>(tank);
  const double share = call(&guard, &board);
  tank = std::bit_cast<Tank>(board);
  return share;
}

ENAMEL_REALTIME inline double GuardedStep(const GuardParams& params, const dvec3& e_m,
                                          const dvec3& w_m, double work_j, Tank& tank) noexcept {
  return OnBoard(params, tank, [&](const EnGuard* guard, EnTank* board) {
    return EnGuardedStep(guard, ToBoard(e_m), ToBoard(w_m), work_j, board);
  });
}

ENAMEL_REALTIME inline double StiffnessShare(const GuardParams& params, const dvec3& e_m,
                                             double bound_n, double share_before,
                                             Tank& tank) noexcept {
  return OnBoard(params, tank, [&](const EnGuard* guard, EnTank* board) {
    return EnStiffnessShare(guard, ToBoard(e_m), bound_n, share_before, board);
  });
}

ENAMEL_REALTIME inline double ResumedShare(const GuardParams& params, const dvec3& e_m,
                                           double kept_j, Tank& tank) noexcept {
  return OnBoard(params, tank, [&](const EnGuard* guard, EnTank* board) {
    return EnResumedShare(guard, ToBoard(e_m), kept_j, board);
  });
}

}  // namespace enamel::haptics
