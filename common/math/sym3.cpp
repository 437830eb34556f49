#include "common/math/sym3.h"

#include <cmath>

namespace enamel {

bool Sym3::IsFinite() const noexcept {
  return std::isfinite(xx) && std::isfinite(yy) && std::isfinite(zz) && std::isfinite(xy) &&
         std::isfinite(xz) && std::isfinite(yz);
}

bool Sym3::IsPositiveSemiDefinite(double tolerance) const noexcept {
  double scale = std::fabs(xx) + std::fabs(yy) + std::fabs(zz);
  double t1 = -tolerance * scale, t2 = t1 * scale, t3 = t2 * scale;
  double minor_xy = xx * yy - xy * xy, minor_xz = xx * zz - xz * xz, minor_yz = yy * zz - yz * yz;
  double det = xx * minor_yz - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  return IsFinite() && xx >= t1 && yy >= t1 && zz >= t1 && minor_xy >= t2 && minor_xz >= t2 &&
         minor_yz >= t2 && det >= t3;
}

dvec3 SolveShifted(const Sym3& a, double s, const dvec3& v) noexcept {
  double d0 = a.xx + s;
  double l10 = a.xy / d0, l20 = a.xz / d0;
  double d1 = (a.yy + s) - l10 * a.xy;
  double t = a.yz - l20 * a.xy;
  double l21 = t / d1;
  double d2 = ((a.zz + s) - l20 * a.xz) - l21 * t;
  double y0 = v.x, y1 = v.y - l10 * y0, y2 = (v.z - l20 * y0) - l21 * y1;
  double z = y2 / d2, y = y1 / d1 - l21 * z;
  return {(y0 / d0 - l10 * y) - l20 * z, y, z};
}

}  // namespace enamel
