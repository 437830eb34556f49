#include "common/scene/molar.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace enamel::scene {
namespace {

using cutting::Tissue;

// Everything below is in millimetres. x mesial, y buccal, z occlusal.
constexpr double kCervicalZ = -3.75;
constexpr double kRootLength = 14.0;
constexpr double kTrunkZ = -6.9;  // where the root trunk ends and the roots part
constexpr double kRootsBelowZ =
    -2.0;  // above it roots and crown do not meet any more, nor does the relief below

double SmoothMax(double a, double b, double k) {
  double h = std::max(k - std::abs(a - b), 0.0);
  return std::max(a, b) + h * h / (4 * k);
}
double SmoothMin(double a, double b, double k) { return -SmoothMax(-a, -b, k); }
double Square(double v) { return v * v; }
double Ramp(double v, double lo, double hi) {
  double t = std::clamp((v - lo) / (hi - lo), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Catmull-Rom curve through samples at z = first, first + step, ...
template <size_t N>
double Curve(const std::array<double, N>& samples, double first, double step, double z) {
  double u = std::clamp((z - first) / step, 0.0, static_cast<double>(N - 1) - 1e-9);
  auto i = static_cast<int>(u);
  double t = u - i;
  auto at = [&](int j) {
    return samples[static_cast<size_t>(std::clamp(j, 0, static_cast<int>(N) - 1))];
  };
  double p0 = at(i - 1), p1 = at(i), p2 = at(i + 1), p3 = at(i + 2);
  return p1 +
         0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)));
}

// --- occlusal relief: a height over (x, y) ---

struct Cusp {
  double x, y, z;  // tip
  double slope;    // fall per mm across the triangular ridge
};
constexpr std::array<Cusp, 5> kCusps = {{
    {2.35, 2.65, 3.70, 0.86},    // mesiobuccal
    {-0.95, 2.75, 3.55, 0.86},   // distobuccal
    {-3.75, 1.35, 3.00, 0.90},   // distal
    {2.25, -2.60, 4.05, 0.84},   // mesiolingual
    {-1.95, -2.65, 3.90, 0.84},  // distolingual
}};
constexpr double kFossaX = -0.10, kFossaY = 0.05;

// A cone with a round tip, drawn out toward the central fossa into a triangular ridge.
double CuspHeight(const Cusp& c, double x, double y) {
  double rx = kFossaX - c.x, ry = kFossaY - c.y;
  double n = 1 / std::sqrt(rx * rx + ry * ry);
  double along = ((x - c.x) * rx + (y - c.y) * ry) * n;
  double across = ((x - c.x) * -ry + (y - c.y) * rx) * n;
  double stretch = along > 0 ? 0.80 : 1.0;
  double r = std::sqrt(Square(stretch * along) + Square(across) + 0.25) - 0.5;
  return c.z - c.slope * r;
}

// A ridge along y at the mesial or distal end of the occlusal table.
double MarginalRidge(double x, double y, double at_x, double top) {
  return top - 1.0 * (std::sqrt(Square(x - at_x) + 0.30 * y * y + 0.16) - 0.4);
}

double OcclusalHeight(double x, double y) {
  double h = -10;
  for (const Cusp& c : kCusps) h = SmoothMax(h, CuspHeight(c, x, y), 0.22);
  h = SmoothMax(h, MarginalRidge(x, y, 4.20, 2.95), 0.7);
  h = SmoothMax(h, MarginalRidge(x, y, -4.30, 2.60), 0.7);
  return h;
}

// --- crown and root trunk: a barrel around the tooth's axis ---

constexpr double kCurveFirst = -7.5, kCurveStep = 1.5;
//                                    z = -7.5   -6    -4.5    -3   -1.5    0    1.5     3    4.5
constexpr std::array<double, 9> kHalfMesial = {3.70, 3.95, 4.30, 4.72, 5.20, 5.48, 5.40, 4.85, 3.9};
constexpr std::array<double, 9> kBuccal = {3.15, 3.55, 4.20, 4.85, 5.05, 4.85, 4.40, 3.75, 2.9};
constexpr std::array<double, 9> kLingual = {3.05, 3.42, 3.92, 4.45, 4.80, 4.95, 4.75, 4.10, 3.2};

// Grooves that run from the occlusal table over the buccal and lingual faces.
double SideGrooves(double x, double y, double z) {
  double fade = Ramp(z, -1.6, 1.5);
  if (fade == 0) return 0;
  double buccal =
      0.42 * std::exp(-Square((x - 0.75) / 0.42)) + 0.34 * std::exp(-Square((x + 2.55) / 0.42));
  double lingual = 0.36 * std::exp(-Square((x - 0.15) / 0.42));
  return fade * (y > 0 ? buccal * Ramp(y, 1.0, 3.0) : lingual * Ramp(-y, 1.0, 3.0));
}

double BarrelDistance(double x, double y, double z) {
  double a = Curve(kHalfMesial, kCurveFirst, kCurveStep, z);
  double yb = Curve(kBuccal, kCurveFirst, kCurveStep, z);
  double yl = Curve(kLingual, kCurveFirst, kCurveStep, z);
  double b = 0.5 * (yb + yl) * (1 + 0.018 * x);
  double u = Square(x / a), v = Square((y - 0.5 * (yb - yl)) / b);
  // Between an ellipse (1.0) and a rounded rectangle (0.0).
  double r = std::sqrt(std::sqrt(u * u + v * v + 0.75 * u * v));
  return (r - 1) * std::min(a, b) + SideGrooves(x, y, z);
}

// --- roots ---

struct Root {
  std::array<double, 5> x;  // centre line at 0, 1/4, 1/2, 3/4, 1 of the length
  std::array<double, 5> half_x, half_y;
  double groove;  // depth of the hollow on its flat faces
};
constexpr Root kMesialRoot = {{2.35, 2.75, 2.95, 2.75, 2.25},
                              {1.95, 1.65, 1.40, 1.12, 0.80},
                              {3.75, 3.45, 2.95, 2.30, 1.55},
                              0.22};
constexpr Root kDistalRoot = {{-2.35, -2.80, -3.10, -3.25, -3.30},
                              {1.90, 1.60, 1.32, 1.05, 0.75},
                              {3.45, 3.05, 2.50, 1.90, 1.25},
                              0.10};

double RootProgress(double z) { return (kCervicalZ - z) / kRootLength; }

double RootDistance(const Root& root, double x, double y, double z) {
  double t = RootProgress(z);
  double cx = Curve(root.x, 0, 0.25, t);
  double rx = Curve(root.half_x, 0, 0.25, t), ry = Curve(root.half_y, 0, 0.25, t);
  double u = (x - cx) / rx, v = (y + 0.25 * t) / ry;
  double t2 = std::max(t, 0.0) * std::max(t, 0.0);
  double t8 = t2 * t2 * t2 * t2;
  double side = (std::sqrt(u * u + v * v + t8 * t2) - 1) * rx;
  side += root.groove * std::exp(-Square(v / 0.35)) * Ramp(t, 0.1, 0.3);
  return SmoothMax(side, z - (kCervicalZ - 0.5), 1.5);
}

double OuterDistance(double x, double y, double z) {
  double body = SmoothMax(BarrelDistance(x, y, z), kTrunkZ - z, 1.6);
  if (z > kRootsBelowZ) return SmoothMax(body, (z - OcclusalHeight(x, y)) * 0.78, 0.9);
  double roots = std::min(RootDistance(kMesialRoot, x, y, z), RootDistance(kDistalRoot, x, y, z));
  return SmoothMin(body, roots, 1.1);
}

// --- tissues ---

// The cervical line rises on the mesial and distal faces.
double CervicalHeight(double x) { return kCervicalZ + 0.75 * Square(x / 4.6); }

// Positive in enamel: distance to the dentin-enamel junction, about mm.
double EnamelDistance(double x, double y, double z) {
  double above = z - CervicalHeight(x);
  if (above <= 0) return std::max(above, -3.0);
  double thickness = 2.45 * above / (above + 1.9);
  double side = BarrelDistance(x, y, z) + thickness;
  double top = (z - (0.55 * OcclusalHeight(x, y) - 0.35)) * 0.85;
  return std::min(SmoothMax(side, top, 1.0), above);
}

double Segment(double x, double y, double z, const dvec3& a, const dvec3& b) {
  dvec3 ab = b - a, ap = dvec3(x, y, z) - a;
  double t = std::clamp(Dot(ap, ab) / Dot(ab, ab), 0.0, 1.0);
  dvec3 d = ap - t * ab;
  return std::sqrt(Dot(d, d));
}

double Canal(const Root& root, double offset_y, double end_y, double half_y, double x, double y,
             double z) {
  double t = RootProgress(z);
  double cx = Curve(root.x, 0, 0.25, t),
         cy = offset_y + (end_y - offset_y) * std::clamp(t, 0.0, 1.0);
  double r = 0.42 - 0.26 * std::clamp(t, 0.0, 1.0);
  double dy = std::max(std::abs(y - cy) - half_y * (1 - t), 0.0);
  double d = std::sqrt(Square(x - cx) + dy * dy) - r;
  return std::max({d, z - (kCervicalZ - 0.8), kCervicalZ - kRootLength + 0.3 - z});
}

// Negative in pulp, about mm.
double PulpDistance(double x, double y, double z) {
  double u = x / 2.5, v = y / 1.7, w = (z + 4.1) / 1.25;
  double chamber = (std::sqrt(std::sqrt(u * u * u * u + v * v * v * v + w * w * w * w +
                                        u * u * v * v + (u * u + v * v) * w * w)) -
                    1) *
                   1.25;
  double horns = 10;
  for (const Cusp& c : kCusps) {
    double hx = 0.72 * c.x, hy = 0.62 * c.y;
    double top = c.z - 5.15;
    horns = std::min(horns, Segment(x, y, z, {0.6 * hx, 0.6 * hy, -3.6}, {hx, hy, top}) -
                                (0.50 - 0.28 * Ramp(z, -3.4, top)));
  }
  double canals = std::min({Canal(kMesialRoot, 1.35, 0.35, 0, x, y, z),
                            Canal(kMesialRoot, -1.35, -0.65, 0, x, y, z),
                            Canal(kDistalRoot, 0, -0.25, 0.9, x, y, z)});
  return SmoothMin(SmoothMin(chamber, horns, 0.35), canals, 0.5);
}

// Outer distance made a true one near the surface: divided by its gradient, shortened far away
// where that is only a guess.
double TrueDistance(double x, double y, double z, double value) {
  constexpr double kStep = 0.01, kNear = 0.45;
  if (std::abs(value) > 2 * kNear) return value * 0.5;
  double gx = OuterDistance(x + kStep, y, z) - value;
  double gy = OuterDistance(x, y + kStep, z) - value;
  double gz = OuterDistance(x, y, z + kStep) - value;
  double gradient = std::sqrt(gx * gx + gy * gy + gz * gz) / kStep;
  double d = value / std::max(gradient, 0.3);
  return std::abs(d) <= kNear ? d : std::copysign(kNear + 0.5 * (std::abs(d) - kNear), d);
}

}  // namespace

FieldSample MolarField(const dvec3& point_m) {
  const double x = point_m.x * 1e3, y = point_m.y * 1e3, z = point_m.z * 1e3;
  double value = OuterDistance(x, y, z);
  FieldSample out{TrueDistance(x, y, z, value) * 1e-3, Tissue::kDentin, 0};
  if (value > 1) return out;
  double enamel = EnamelDistance(x, y, z), pulp = PulpDistance(x, y, z);
  if (pulp < 0) {
    out.tissue = Tissue::kPulp;
  } else if (enamel > 0) {
    out.tissue = Tissue::kEnamel;
  }
  out.tissue_margin_m = 0.5e-3 * std::min(std::abs(enamel), std::abs(pulp));
  return out;
}

MolarBox MolarBounds() { return {dvec3(-5.8, -5.6, -18.2) * 1e-3, dvec3(5.8, 5.6, 4.4) * 1e-3}; }

dvec3 MolarCentralFossa() {
  // The lowest point of the relief near the middle, by descent on a shrinking pattern.
  double x = kFossaX, y = kFossaY;
  for (double step = 0.2; step > 1e-4; step *= 0.5) {
    for (bool moved = true; moved;) {
      moved = false;
      for (int i = 0; i < 4; ++i) {
        double nx = x + (i == 0   ? step
                         : i == 1 ? -step
                                  : 0),
               ny = y + (i == 2   ? step
                         : i == 3 ? -step
                                  : 0);
        if (OcclusalHeight(nx, ny) >= OcclusalHeight(x, y)) continue;
        x = nx, y = ny, moved = true;
      }
    }
  }
  double lo = -1, hi = 5;
  for (int i = 0; i < 40; ++i) {
    double mid = 0.5 * (lo + hi);
    (OuterDistance(x, y, mid) < 0 ? lo : hi) = mid;
  }
  return dvec3(x, y, lo) * 1e-3;
}

}  // namespace enamel::scene
