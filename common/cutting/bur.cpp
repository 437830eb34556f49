#include "common/cutting/bur.h"

#include <cmath>

#include "common/math/trig.h"

namespace enamel::cutting {
namespace {

constexpr double kPi = 3.14159265358979323846;

int CountAlong(double length, double spacing, int at_least) {
  int n = static_cast<int>(length / spacing + 0.5);
  return n < at_least ? at_least : n;
}

// Every second ring is turned by half a step, so that points do not line up along the axis.
double RingTurn(int j, int around, int ring) {
  double turn = (j + 0.5 * (ring % 2)) / around;
  return turn < 1 ? turn : turn - 1;
}

void SampleSphere(const Bur& bur, double spacing, std::vector<SurfacePoint>& out) {
  double r = bur.radius_m;
  int rings = CountAlong(kPi * r, spacing, 4);
  for (int i = 0; i < rings; ++i) {
    // Polar angle in turns: half a turn from pole to pole. A band's area is 2 pi r times its
    // height (Archimedes).
    SinCos lo = SinCosOfTurns(0.5 * i / rings), hi = SinCosOfTurns(0.5 * (i + 1) / rings),
           mid = SinCosOfTurns(0.5 * (i + 0.5) / rings);
    int around = CountAlong(2 * kPi * r * mid.sin, spacing, 4);
    double area = 2 * kPi * r * r * (lo.cos - hi.cos) / around;
    for (int j = 0; j < around; ++j) {
      SinCos t = SinCosOfTurns(RingTurn(j, around, i));
      dvec3 n(mid.sin * t.cos, mid.sin * t.sin, -mid.cos);
      out.push_back({dvec3(0, 0, r) + r * n, n, area});
    }
  }
}

void SampleCylinder(const Bur& bur, double spacing, std::vector<SurfacePoint>& out) {
  double r = bur.radius_m, length = bur.length_m;
  int around = CountAlong(2 * kPi * r, spacing, 12), rows = CountAlong(length, spacing, 1);
  for (int i = 0; i < rows; ++i) {
    double z = length * (i + 0.5) / rows;
    for (int j = 0; j < around; ++j) {
      SinCos t = SinCosOfTurns(RingTurn(j, around, i));
      dvec3 n(t.cos, t.sin, 0);
      out.push_back({r * n + dvec3(0, 0, z), n, 2 * kPi * r * length / (around * rows)});
    }
  }
  int rings = CountAlong(r, spacing, 2);
  for (int i = 0; i < rings; ++i) {
    double lo = r * i / rings, hi = r * (i + 1) / rings, rho = std::sqrt(0.5 * (lo * lo + hi * hi));
    int on_ring = CountAlong(2 * kPi * rho, spacing, 4);
    for (int j = 0; j < on_ring; ++j) {
      SinCos t = SinCosOfTurns(RingTurn(j, on_ring, i));
      out.push_back({dvec3(rho * t.cos, rho * t.sin, 0), dvec3(0, 0, -1),
                     kPi * (hi * hi - lo * lo) / on_ring});
    }
  }
}

}  // namespace

double Bur::Distance(const dvec3& p) const noexcept {
  if (shape == BurShape::kSphere) {
    double z = p.z - radius_m;
    return std::sqrt((p.x * p.x + p.y * p.y) + z * z) - radius_m;
  }
  double side = std::sqrt(p.x * p.x + p.y * p.y) - radius_m;
  double half = 0.5 * length_m;
  double end = std::fabs(p.z - half) - half;
  if (side <= 0 || end <= 0) return side > end ? side : end;
  return std::sqrt(side * side + end * end);
}

std::vector<SurfacePoint> SampleSurface(const Bur& bur, double spacing_m, size_t max_points) {
  std::vector<SurfacePoint> out;
  for (double spacing = spacing_m;; spacing *= 1.1) {
    out.clear();
    if (bur.shape == BurShape::kSphere) SampleSphere(bur, spacing, out);
    else SampleCylinder(bur, spacing, out);
    if (out.size() <= max_points) return out;
  }
}

}  // namespace enamel::cutting
