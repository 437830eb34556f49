#include "common/scene/builtin/tooth_shape.h"

#include <algorithm>
#include <cmath>

#include "common/math/ramp.h"

namespace enamel::scene {
namespace {

using cutting::Tissue;

// The larger, rounded by a parabola where the two are within k: at most k/4 above it.
double SmoothMax(double a, double b, double k) {
  double h = std::max(k - std::abs(a - b), 0.0);
  return std::max(a, b) + h * h / (4 * k);
}
double SmoothMin(double a, double b, double k) { return -SmoothMax(-a, -b, k); }
double Square(double v) { return v * v; }

// Catmull-Rom curve through samples at u = 0, 1, ...; level beyond its ends.
template <size_t N>
double Curve(const std::array<double, N>& samples, double u) {
  u = std::clamp(u, 0.0, static_cast<double>(N - 1) - 1e-9);
  auto i = static_cast<int>(u);
  double t = u - i;
  auto at = [&](int j) {
    return samples[static_cast<size_t>(std::clamp(j, 0, static_cast<int>(N) - 1))];
  };
  double p0 = at(i - 1), p1 = at(i), p2 = at(i + 1), p3 = at(i + 2);
  return p1 +
         0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)));
}

double SectionPlace(const Sections& s, double z) { return (z - s.first_z) / s.step_z; }

double CuspHeight(const ToothShape& shape, const Cusp& c, double x, double y) {
  double rx = shape.fossa_x - c.x, ry = shape.fossa_y - c.y;
  double n = 1 / std::sqrt(rx * rx + ry * ry);
  double along = ((x - c.x) * rx + (y - c.y) * ry) * n;
  double across = ((x - c.x) * -ry + (y - c.y) * rx) * n;
  // Toward the fossa the cone is drawn out, which makes the triangular ridge.
  double stretch = along > 0 ? 0.80 : 1.0;
  // The cone's point rounded off with a radius of half a millimetre.
  double r = std::sqrt(Square(stretch * along) + Square(across) + 0.25) - 0.5;
  return c.z - c.slope * r;
}

double RidgeHeight(const Ridge& r, double x, double y) {
  double d2 = r.weight_x * Square(x - r.x) + r.weight_y * Square(y - r.y);
  return r.top - r.fall * (std::sqrt(d2 + 0.16) - 0.4);
}

double GrooveDepth(const SideGroove& g, double x, double y, double z) {
  const double fade = Ramp(z, g.fade_from_z, g.fade_to_z) * (1 - Ramp(z, g.end_from_z, g.end_to_z));
  const double out = g.face == Face::kMesial ? x : g.face == Face::kBuccal ? y : -y;
  if (fade == 0 || out <= 0) return 0;
  const double along = g.face == Face::kMesial ? y : x;
  return fade * g.depth * std::exp(-Square((along - g.at) / g.width)) * Ramp(out, 0.3, 2.0);
}

double FissureDepth(const Fissure& f, double x, double y) {
  const double dx = f.to_x - f.from_x, dy = f.to_y - f.from_y;
  const double t =
      std::clamp(((x - f.from_x) * dx + (y - f.from_y) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  const double away2 = Square(x - f.from_x - t * dx) + Square(y - f.from_y - t * dy);
  return f.depth * std::exp(-away2 / Square(f.width));
}

// Of a half extent, at `place` between the narrow end (-1) and the wide one (1). Scaled so that the
// section is nowhere wider than without a taper: near the middle its outline falls by round/4
// place^2.
double Tapered(double taper, double round, double place) {
  if (taper == 0) return 1;
  const double slope = 0.5 * taper;
  return (1 + slope * place) / (1 + slope * slope / round);
}

// From one value at -1 to another at 1.
double Turned(double from, double to, double place) {
  return from + (to - from) * Ramp(place, -1, 1);
}

double SideDistance(const ToothShape& shape, double x, double y, double z) {
  const Sections& s = shape.sections;
  double u = SectionPlace(s, z);
  double a = Curve(x > 0 ? s.mesial : s.distal, u);
  double dy = y - Curve(s.middle_y, u);
  double b = Curve(dy > 0 ? s.buccal : s.lingual, u);
  const double v = std::clamp(dy / b, -1.0, 1.0), w = std::clamp(x / a, -1.0, 1.0);
  a *= Tapered(s.lingual_taper, s.round, v);
  b *= Tapered(s.distal_taper, s.round, w);
  double p = Square(x / a), q = Square(dy / b);
  double r = std::sqrt(std::sqrt(p * p + q * q + s.round * p * q));
  // No distance, but of the right sign; TrueDistance makes one of it near the surface. The other half
  // extent takes over gradually: where the scale jumped, the gradient across would be far too large.
  constexpr double kOver = 0.5;
  const double wide = Turned(Curve(s.distal, u), Curve(s.mesial, u), x / kOver),
               deep = Turned(Curve(s.lingual, u), Curve(s.buccal, u), dy / kOver);
  double d = (r - 1) * std::min(wide, deep);
  for (const SideGroove& g : shape.grooves) d += GrooveDepth(g, x, dy, z);
  return d;
}

double RootProgress(const ToothShape& shape, const Root& root, double z) {
  return (shape.cervical_z - z) / root.length;
}

double RootDistance(const ToothShape& shape, const Root& root, double x, double y, double z) {
  double t = RootProgress(shape, root, z);
  double rx = Curve(root.half_x, 4 * t), ry = Curve(root.half_y, 4 * t);
  double u = (x - Curve(root.x, 4 * t)) / rx, v = (y - Curve(root.y, 4 * t)) / ry;
  // The tenth power leaves a root alone for most of its length and rounds its end off.
  double t2 = Square(std::max(t, 0.0));
  double t8 = t2 * t2 * t2 * t2;
  double side = (std::sqrt(u * u + v * v + t8 * t2) - 1) * std::min(rx, ry);
  side += root.groove * std::exp(-Square(v / 0.35)) * Ramp(t, 0.1, 0.3);
  return SmoothMax(side, z - (shape.cervical_z - 0.5), 1.5);
}

double ReliefHeight(const ToothShape& shape, double x, double y) {
  double h = -10;
  for (const Cusp& c : shape.cusps)
    h = SmoothMax(h, CuspHeight(shape, c, x, y), shape.relief_blend);
  for (const Ridge& r : shape.ridges) h = SmoothMax(h, RidgeHeight(r, x, y), 0.7);
  for (const Fissure& f : shape.fissures) h -= FissureDepth(f, x, y);
  return h;
}

double OuterDistance(const ToothShape& shape, double x, double y, double z) {
  double body = SmoothMax(SideDistance(shape, x, y, z), shape.trunk_z - z, shape.trunk_blend);
  // Above the cervical line's neighbourhood crown and roots do not meet, nor does the relief below.
  if (z > shape.cervical_z + 1.75) {
    // 0.78: a height over a slope of 0.8 per mm as a distance.
    return SmoothMax(body, (z - ReliefHeight(shape, x, y)) * 0.78, shape.edge_blend);
  }
  double roots = 1e3;
  for (const Root& r : shape.roots) roots = std::min(roots, RootDistance(shape, r, x, y, z));
  return SmoothMin(body, roots, 1.1);
}

// The cervical line curves toward the crown on the mesial and distal faces.
double CervicalHeight(const ToothShape& shape, double x) {
  double half = Curve(x > 0 ? shape.sections.mesial : shape.sections.distal,
                      SectionPlace(shape.sections, shape.cervical_z));
  double rise = x > 0 ? shape.enamel.mesial_rise : shape.enamel.distal_rise;
  return shape.cervical_z + rise * std::min(Square(x / half), 1.0);
}

// Positive in enamel: distance to the dentin-enamel junction, about mm.
double EnamelDistance(const ToothShape& shape, double x, double y, double z) {
  const EnamelCap& cap = shape.enamel;
  double above = z - CervicalHeight(shape, x);
  if (above <= 0) return std::max(above, -3.0);
  double side = SideDistance(shape, x, y, z) + cap.side * above / (above + cap.rise);
  double top = (z - (cap.relief * ReliefHeight(shape, x, y) - cap.drop)) * 0.85;
  return std::min(SmoothMax(side, top, 1.0), above);
}

double Segment(const dvec3& p, const dvec3& a, const dvec3& b) {
  dvec3 ab = b - a, ap = p - a;
  double t = std::clamp(Dot(ap, ab) / Dot(ab, ab), 0.0, 1.0);
  dvec3 d = ap - t * ab;
  return std::sqrt(Dot(d, d));
}

double CanalDistance(const ToothShape& shape, const Canal& c, double x, double y, double z) {
  const Root& root = shape.roots[c.root];
  double t = RootProgress(shape, root, z), along = std::clamp(t, 0.0, 1.0);
  double cx = Curve(root.x, 4 * t);
  double cy = Curve(root.y, 4 * t) + c.offset_y + (c.end_y - c.offset_y) * along;
  double r = c.radius + (c.apex_radius - c.radius) * along;
  double dy = std::max(std::abs(y - cy) - c.flat_y * (1 - along), 0.0);
  double d = std::sqrt(Square(x - cx) + dy * dy) - r;
  return std::max({d, z - shape.pulp.middle.z, shape.cervical_z - root.length + 0.3 - z});
}

// Negative in pulp, about mm.
double PulpDistance(const ToothShape& shape, double x, double y, double z) {
  const Pulp& pulp = shape.pulp;
  double u = Square((x - pulp.middle.x) / pulp.half.x),
         v = Square((y - pulp.middle.y) / pulp.half.y),
         w = Square((z - pulp.middle.z) / pulp.half.z);
  double r = std::sqrt(std::sqrt(u * u + v * v + w * w + u * v + (u + v) * w));
  double d = (r - 1) * std::min({pulp.half.x, pulp.half.y, pulp.half.z});
  double horns = 10;
  for (const Cusp& c : shape.cusps) {
    dvec3 tip(pulp.lean_x * c.x, pulp.lean_y * c.y, c.z - pulp.depth);
    dvec3 foot(0.6 * tip.x, 0.6 * tip.y, pulp.middle.z + 0.4 * pulp.half.z);
    double radius = pulp.radius + (pulp.tip_radius - pulp.radius) * Ramp(z, foot.z, tip.z);
    horns = std::min(horns, Segment({x, y, z}, foot, tip) - radius);
  }
  double canals = 10;
  for (const Canal& c : pulp.canals) canals = std::min(canals, CanalDistance(shape, c, x, y, z));
  return SmoothMin(SmoothMin(d, horns, 0.35), canals, 0.5);
}

// Outer distance made a true one near the surface: divided by its gradient, shortened far away
// where that is only a guess.
double TrueDistance(const ToothShape& shape, double x, double y, double z, double value) {
  constexpr double kStep = 0.01, kNear = 0.45;
  // f / |grad f|, the first-order distance (Taubin, ACM Transactions on Graphics 13, 1994), within
  // 0.45 mm. That holds the builder's band of 4 voxels up to voxels of 0.11 mm.
  if (std::abs(value) > 2 * kNear) return value * 0.5;
  double gx = OuterDistance(shape, x + kStep, y, z) - value;
  double gy = OuterDistance(shape, x, y + kStep, z) - value;
  double gz = OuterDistance(shape, x, y, z + kStep) - value;
  double gradient = std::sqrt(gx * gx + gy * gy + gz * gz) / kStep;
  double d = value / std::max(gradient, 0.3);
  return std::abs(d) <= kNear ? d : std::copysign(kNear + 0.5 * (std::abs(d) - kNear), d);
}

// First solid below (x, y) from above.
std::optional<dvec3> SurfaceBelow(const ToothShape& shape, double x, double y) {
  double z = shape.hi.z + 0.5;
  while (OuterDistance(shape, x, y, z) > 0) {
    if ((z -= 0.05) < shape.lo.z) return std::nullopt;
  }
  double lo = z, hi = z + 0.05;
  for (int i = 0; i < 30; ++i) {
    double mid = 0.5 * (lo + hi);
    (OuterDistance(shape, x, y, mid) < 0 ? lo : hi) = mid;
  }
  return dvec3(x, y, lo);
}

// The lowest point of the relief near the fossa, on the surface.
dvec3 FossaBottom(const ToothShape& shape) {
  // Descent on a shrinking pattern.
  constexpr double kAround[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  double x = shape.fossa_x, y = shape.fossa_y;
  if (shape.cusps.empty()) return SurfaceBelow(shape, x, y).value_or(dvec3(0));
  for (double step = 0.2; step > 1e-4; step *= 0.5) {
    for (bool moved = true; moved;) {
      moved = false;
      for (const auto& d : kAround) {
        double nx = x + step * d[0], ny = y + step * d[1];
        // Within a millimetre of where it was drawn, or the descent would run out over a marginal
        // ridge.
        if (std::abs(nx - shape.fossa_x) > 1 || std::abs(ny - shape.fossa_y) > 1) continue;
        if (ReliefHeight(shape, nx, ny) >= ReliefHeight(shape, x, y)) continue;
        x = nx, y = ny, moved = true;
      }
    }
  }
  return SurfaceBelow(shape, x, y).value_or(dvec3(0));
}

// From the frame of a description to the scene's, and back.
dvec3 Mirrored(const ToothShape& shape, const dvec3& p) { return {shape.Along(p.x), p.y, p.z}; }

}  // namespace

FieldSample ToothField(const ToothShape& shape, const dvec3& point_m) {
  const double x = shape.Along(point_m.x) * 1e3, y = point_m.y * 1e3, z = point_m.z * 1e3;
  double value = OuterDistance(shape, x, y, z);
  FieldSample out{TrueDistance(shape, x, y, z, value) * 1e-3, Tissue::kDentin, 0};
  if (value > 1) return out;
  double enamel = EnamelDistance(shape, x, y, z), pulp = PulpDistance(shape, x, y, z);
  if (pulp < 0) {
    out.tissue = Tissue::kPulp;
  } else if (enamel > 0) {
    out.tissue = Tissue::kEnamel;
  }
  // Half: the two are of the right sign, but no true distances.
  out.tissue_margin_m = 0.5e-3 * std::min(std::abs(enamel), std::abs(pulp));
  return out;
}

double CervicalHeight_mm(const ToothShape& shape, double x) {
  return CervicalHeight(shape, shape.Along(x));
}

double OcclusalHeight_mm(const ToothShape& shape, double x, double y) {
  return ReliefHeight(shape, shape.Along(x), y);
}

std::optional<dvec3> SurfaceBelow_m(const ToothShape& shape, double x, double y) {
  const auto found = SurfaceBelow(shape, shape.Along(x), y);
  if (!found) return std::nullopt;
  return Mirrored(shape, *found) * 1e-3;
}

dvec3 FossaBottom_m(const ToothShape& shape) { return Mirrored(shape, FossaBottom(shape)) * 1e-3; }

std::array<dvec3, 2> BoundsOf_m(const ToothShape& shape) {
  const dvec3 a = Mirrored(shape, shape.lo) * 1e-3, b = Mirrored(shape, shape.hi) * 1e-3;
  return {glm::min(a, b), glm::max(a, b)};
}

std::array<double, 4> SectionAt_mm(const ToothShape& shape, double z) {
  const Sections& s = shape.sections;
  double u = SectionPlace(s, z), middle = Curve(s.middle_y, u);
  return {Curve(s.mesial, u), Curve(s.distal, u), middle + Curve(s.buccal, u),
          Curve(s.lingual, u) - middle};
}

}  // namespace enamel::scene
