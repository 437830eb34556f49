#include "station/devices/outline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace enamel::station {
namespace {

using glm::dvec2;

constexpr int kDiscCorners = 24;  // the circle's corners are 17 um off at a tip's radius of 2 mm
constexpr int kArcCorners = 4;

double Cross(const dvec2& a, const dvec2& b) { return a.x * b.y - a.y * b.x; }
double Dot2(const dvec2& a, const dvec2& b) { return a.x * b.x + a.y * b.y; }

// A side's line: outward . p = reach.
struct Line {
  dvec2 outward;
  double reach;
};

bool IsUpright(const Outline& o) {
  if (o.size() != 4) return false;
  for (size_t i = 0; i < 4; ++i) {
    const dvec2 e = o[(i + 1) % 4] - o[i];
    if (e.x != 0 && e.y != 0) return false;
  }
  return true;
}

// Corners where each of a rectangle's lines meets the previous one: exact to the last bit. Empty if
// it has turned inside out.
Outline CornersOf(const std::vector<Line>& lines) {
  Outline out;
  for (size_t i = 0; i < lines.size(); ++i) {
    const Line &a = lines[(i + lines.size() - 1) % lines.size()], &b = lines[i];
    const double det = Cross(a.outward, b.outward);
    out.emplace_back((a.reach * b.outward.y - b.reach * a.outward.y) / det,
                     (b.reach * a.outward.x - a.reach * b.outward.x) / det);
  }
  for (size_t i = 0; i < lines.size(); ++i) {
    const dvec2 &n = lines[i].outward, along(-n.y, n.x);
    if (Dot2(out[(i + 1) % out.size()] - out[i], along) < -1e-12) return {};
  }
  return out;
}

// The part on the inner side of a line.
Outline Clipped(const Outline& outline, const Line& line) {
  constexpr double kSame_m = 1e-9;
  Outline kept;
  auto keep = [&](const dvec2& p) {
    if (kept.empty() || Dot2(p - kept.back(), p - kept.back()) > kSame_m * kSame_m) {
      kept.push_back(p);
    }
  };
  for (size_t i = 0; i < outline.size(); ++i) {
    const dvec2 &p = outline[i], &q = outline[(i + 1) % outline.size()];
    const double dp = Dot2(line.outward, p) - line.reach;
    const double dq = Dot2(line.outward, q) - line.reach;
    if (dp <= 0) keep(p);
    if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) keep(p + (q - p) * (dp / (dp - dq)));
  }
  while (kept.size() > 1 &&
         Dot2(kept[0] - kept.back(), kept[0] - kept.back()) <= kSame_m * kSame_m) {
    kept.pop_back();
  }
  return kept.size() < 3 ? Outline() : kept;
}

}  // namespace

Outline RectangleOf(const Bounds& b) {
  return {{b.x0, b.y0}, {b.x1, b.y0}, {b.x1, b.y1}, {b.x0, b.y1}};
}

Bounds BoundsOf(const Outline& outline) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Bounds b{kFar, -kFar, kFar, -kFar};
  for (const dvec2& p : outline) {
    b.x0 = std::min(b.x0, p.x), b.x1 = std::max(b.x1, p.x);
    b.y0 = std::min(b.y0, p.y), b.y1 = std::max(b.y1, p.y);
  }
  return b;
}

bool IsConvex(const Outline& o) {
  for (size_t i = 0; i < o.size(); ++i) {
    const dvec2 &a = o[i], &b = o[(i + 1) % o.size()], &c = o[(i + 2) % o.size()];
    if (!(Cross(b - a, c - b) > 0)) return false;
  }
  return o.size() >= 3;
}

Outline OutlineOf(const scene::PreparationPart& part) {
  const dvec2 middle(part.top_um[0] * 1e-6, part.top_um[1] * 1e-6);
  const double hx = part.half_size_um[0] * 1e-6, hy = part.half_size_um[1] * 1e-6;
  Outline out;
  switch (part.outline) {
    case scene::PreparationPart::Outline::kDisc:
      for (int i = 0; i < kDiscCorners; ++i) {
        const double angle = (2 * i + 1) * std::numbers::pi / kDiscCorners,
                     r = hx / std::cos(std::numbers::pi / kDiscCorners);
        out.push_back(middle + r * dvec2(std::cos(angle), std::sin(angle)));
      }
      return out;
    case scene::PreparationPart::Outline::kPolygon:
      for (const auto& c : part.corners_um) out.push_back(middle + dvec2(c[0], c[1]) * 1e-6);
      return out;
    default:
      return RectangleOf({middle.x - hx, middle.x + hx, middle.y - hy, middle.y + hy});
  }
}

Outline SectionOf(const scene::PreparationPart& part, double z_m) {
  const scene::Stump& s = part.stump;
  const double foot_z = (part.top_um[2] - part.depth_um) * 1e-6;
  const double t = (z_m - foot_z) / ((part.depth_um - s.table_below_um) * 1e-6);
  auto mix = [&](int32_t foot_um, int32_t table_um) {
    return (foot_um + t * (table_um - foot_um)) * 1e-6;
  };
  const dvec2 middle(part.top_um[0] * 1e-6 + mix(s.foot.middle_um[0], s.table.middle_um[0]),
                     part.top_um[1] * 1e-6 + mix(s.foot.middle_um[1], s.table.middle_um[1]));
  const dvec2 half(mix(s.foot.half_um[0], s.table.half_um[0]),
                   mix(s.foot.half_um[1], s.table.half_um[1]));
  // Never all of a side: each arc ends in a separate corner.
  const double r = std::min(s.corner_um * 1e-6, 0.95 * std::min(half.x, half.y));
  Outline out;
  for (int i = 0; i < 4 * kArcCorners; ++i) {
    const int quarter = i / kArcCorners;
    const double angle =
        std::numbers::pi / 2 * (quarter + static_cast<double>(i % kArcCorners) / (kArcCorners - 1));
    const dvec2 sign(quarter == 0 || quarter == 3 ? 1 : -1, quarter < 2 ? 1 : -1);
    out.push_back(middle + sign * (half - r) + r * dvec2(std::cos(angle), std::sin(angle)));
  }
  return out;
}

Outline Moved(const Outline& outline, const std::function<double(const dvec2&)>& by_m) {
  std::vector<Line> lines;
  for (size_t i = 0; i < outline.size(); ++i) {
    const dvec2 a = outline[i], e = outline[(i + 1) % outline.size()] - a;
    const double length = std::sqrt(Dot2(e, e));
    if (!(length > 0)) continue;
    const dvec2 outward = dvec2(e.y, -e.x) / length;
    lines.push_back({outward, Dot2(outward, a) + by_m(outward)});
  }
  if (IsUpright(outline)) return CornersOf(lines);
  // Bounded by all its lines, starting from a square that contains it.
  const Bounds b = BoundsOf(outline);
  const double far = 4 * std::max(b.x1 - b.x0, b.y1 - b.y0);
  Outline out = RectangleOf({b.x0 - far, b.x1 + far, b.y0 - far, b.y1 + far});
  for (const Line& line : lines) out = Clipped(out, line);
  return out;
}

Outline Grown(const Outline& outline, double by_m) {
  return Moved(outline, [=](const dvec2&) { return by_m; });
}

Outline Within(const Outline& outline, const Bounds& b) {
  Outline out = outline;
  const Line limits[] = {{{1, 0}, b.x1}, {{-1, 0}, -b.x0}, {{0, 1}, b.y1}, {{0, -1}, -b.y0}};
  for (const Line& limit : limits) out = Clipped(out, limit);
  return out;
}

double Inradius(const Outline& outline) {
  const Bounds b = BoundsOf(outline);
  double hi = 0.5 * std::min(b.x1 - b.x0, b.y1 - b.y0);
  if (IsUpright(outline)) return hi;
  double lo = 0;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (lo + hi);
    (Grown(outline, -middle).empty() ? hi : lo) = middle;
  }
  return lo;
}

std::vector<dvec3> CornersAt(const Outline& outline, double z_m, bool clockwise) {
  std::vector<dvec3> out;
  for (const dvec2& p : outline) out.emplace_back(p.x, p.y, z_m);
  if (clockwise) std::reverse(out.begin() + 1, out.end());
  return out;
}

}  // namespace enamel::station
