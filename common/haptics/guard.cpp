#include "common/haptics/guard.h"

#include <cmath>

namespace enamel::haptics {

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

}  // namespace enamel::haptics
