#pragma once

#include "common/math/vec.h"

namespace enamel {

// Symmetric 3 x 3 matrix, six numbers: damping matrices, contact tensors. Real-time: safe.
struct Sym3 {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  static constexpr Sym3 Isotropic(double v) { return {v, v, v, 0, 0, 0}; }
  // w * n * transpose(n)
  static Sym3 Outer(const dvec3& n, double w) noexcept {
    return {w * n.x * n.x, w * n.y * n.y, w * n.z * n.z,
            w * n.x * n.y, w * n.x * n.z, w * n.y * n.z};
  }
  Sym3& operator+=(const Sym3& o) noexcept {
    xx += o.xx;
    yy += o.yy;
    zz += o.zz;
    xy += o.xy;
    xz += o.xz;
    yz += o.yz;
    return *this;
  }
  friend Sym3 operator+(Sym3 a, const Sym3& b) noexcept { return a += b; }
  friend Sym3 operator*(const Sym3& a, double s) noexcept {
    return {a.xx * s, a.yy * s, a.zz * s, a.xy * s, a.xz * s, a.yz * s};
  }
  friend dvec3 operator*(const Sym3& a, const dvec3& v) noexcept {
    return {a.xx * v.x + a.xy * v.y + a.xz * v.z, a.xy * v.x + a.yy * v.y + a.yz * v.z,
            a.xz * v.x + a.yz * v.y + a.zz * v.z};
  }
  double Trace() const noexcept { return xx + yy + zz; }
  bool IsZero() const noexcept {
    return xx == 0 && yy == 0 && zz == 0 && xy == 0 && xz == 0 && yz == 0;
  }
  bool IsFinite() const noexcept;
  // All principal minors >= -tolerance * scale: positive semi-definite within rounding.
  bool IsPositiveSemiDefinite(double tolerance) const noexcept;
};

// Solves (a + s I) x = v for positive semi-definite a and s > 0 by LDL^T without pivoting, which
// is stable for such matrices. Only + - * /, so bit-identical everywhere.
dvec3 SolveShifted(const Sym3& a, double s, const dvec3& v) noexcept;

}  // namespace enamel
