#include "common/scoring/mistakes/wall_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "common/scoring/mistakes/groups.h"

namespace enamel::scoring {
namespace {

constexpr double kRow_mm = 0.2;  // a piece's width
constexpr double kMm = 1e3, kDegrees = 180 / std::numbers::pi;
// A share of the typical amount. A wall that leans from its foot reaches it at a quarter of its height.
constexpr double kMoved = 0.35;
// A part that comes this near to an end of the region reaches it. Less than a piece is wide. Chosen.
constexpr double kEnd_mm = 0.15;

// A piece as a point of the region's own plane.
struct Point {
  double width_mm = 0, height_mm = 0, area = 0, off_mm = 0;
  bool at_edge = false;
};

struct Range {
  double lo = std::numeric_limits<double>::max(), hi = std::numeric_limits<double>::lowest();
  void Take(double at) { lo = std::min(lo, at), hi = std::max(hi, at); }
  double length() const { return hi > lo ? hi - lo : 0; }
};

std::vector<Point> PointsOf(const AcceptableCut& r, size_t region,
                            const std::vector<double>& off_mm) {
  dvec3 normal(0);
  for (const SurfacePiece& p : r.pieces()) {
    if (p.region == region) normal += p.area_m2 * p.normal;
  }
  const double flat = std::sqrt(normal.x * normal.x + normal.y * normal.y);
  const dvec3 along = flat > 0 ? dvec3(-normal.y, normal.x, 0) / flat : dvec3(1, 0, 0);
  std::vector<Point> out;
  for (size_t i = 0; i < off_mm.size(); ++i) {
    const SurfacePiece& p = r.pieces()[i];
    if (p.region != region) continue;
    out.push_back({Dot(along, p.at_m) * kMm, p.at_m.z * kMm, p.area_m2, off_mm[i], p.at_edge});
  }
  return out;
}

// d = a + b (z - middle) by least squares, of d averaged over the width. Pieces at edges have what other walls moved,
// too.
void FitLine(const std::vector<Point>& points, RegionFit& fit) {
  struct Row {
    double area = 0, d = 0, z = 0;
  };
  std::map<int, Row> rows;
  Range heights;
  double area = 0, z = 0, d = 0;
  for (const Point& p : points) {
    if (p.at_edge) continue;
    Row& row = rows[static_cast<int>(std::floor(p.height_mm / kRow_mm))];
    row.area += p.area, row.d += p.area * p.off_mm, row.z += p.area * p.height_mm;
    area += p.area, z += p.area * p.height_mm, d += p.area * p.off_mm;
    heights.Take(p.height_mm);
  }
  if (!(area > 0)) return;
  const double middle = z / area;
  double zz = 0, dz = 0, dd = 0;
  for (const auto& [k, row] : rows) {
    const double up = row.z / row.area - middle, off = row.d / row.area;
    zz += row.area * up * up;
    dz += row.area * up * off;
    dd += row.area * off * off;
  }
  const double slope = zz > 0 ? dz / zz : 0;
  fit.moved_mm = d / area;
  fit.rows = static_cast<int>(rows.size());
  fit.lean_deg = std::atan(slope) * kDegrees;
  fit.half_height_mm = 0.5 * heights.length();
  fit.explained = dd > 0 ? (d * d / area + slope * dz) / dd : 0;
}

// Takes the median of means around each piece: the volume at a single piece is off by up to a column of voxels.
void FindMedian(std::vector<Point> points, RegionFit& fit) {
  constexpr double kAround_mm = 0.35;
  std::erase_if(points, [](const Point& p) { return p.at_edge; });
  const std::vector<Point> own = points;
  for (Point& p : points) {
    double area = 0, off = 0;
    for (const Point& q : own) {
      if (std::fabs(q.width_mm - p.width_mm) > kAround_mm ||
          std::fabs(q.height_mm - p.height_mm) > kAround_mm)
        continue;
      area += q.area, off += q.area * q.off_mm;
    }
    p.off_mm = off / area;
  }
  std::ranges::sort(points, {}, &Point::off_mm);
  double area = 0, below = 0;
  for (const Point& p : points) area += p.area;
  for (const Point& p : points) {
    fit.median_mm = p.off_mm;
    below += p.area;
    if (2 * below >= area) return;
  }
}

void MeasurePart(const std::vector<Point>& points, RegionFit& fit) {
  double sum[2] = {0, 0}, square[2] = {0, 0}, all = 0;
  for (const Point& p : points) {
    const size_t over = p.off_mm > 0;
    sum[over] += p.area * std::fabs(p.off_mm);
    square[over] += p.area * p.off_mm * p.off_mm;
    all += p.area;
  }
  const size_t over = square[1] > square[0];
  if (!(sum[over] > 0)) return;
  const double typical_mm = square[over] / sum[over];
  Range width, height, whole_width, whole_height;
  double area = 0, at = 0;
  for (const Point& p : points) {
    whole_width.Take(p.width_mm), whole_height.Take(p.height_mm);
    if ((over ? p.off_mm : -p.off_mm) < kMoved * typical_mm) continue;
    width.Take(p.width_mm), height.Take(p.height_mm);
    area += p.area, at += p.area * p.height_mm;
  }
  if (!(area > 0)) return;
  auto of = [](const Range& part, const Range& whole) {
    return whole.length() > 0 ? part.length() / whole.length() : 1;
  };
  fit.of_area = area / all;
  fit.of_width = of(width, whole_width), fit.of_height = of(height, whole_height);
  fit.at_end = std::min(width.lo - whole_width.lo, whole_width.hi - width.hi) < kEnd_mm;
  fit.at_height =
      whole_height.length() > 0 ? (at / area - whole_height.lo) / whole_height.length() : 0.5;
}

}  // namespace

RegionFit FitRegion(const AcceptableCut& r, size_t region, const std::vector<double>& off_mm) {
  const std::vector<Point> points = PointsOf(r, region, off_mm);
  RegionFit fit;
  FitLine(points, fit);
  FindMedian(points, fit);
  MeasurePart(points, fit);
  return fit;
}

bool IsWavy(const AcceptableCut& r, size_t region, const std::vector<double>& off_mm) {
  constexpr double kConnected_mm = 0.3;
  constexpr int kTwice = 2;
  const auto& regions = r.regions();
  const RegionKind kind = regions[region].kind;
  const bool alone = IsWall(kind);
  auto counts = [&](const SurfacePiece& p) {
    return !p.at_edge && (alone ? p.region == region : regions[p.region].kind == kind);
  };
  double sum = 0, square = 0;
  for (size_t i = 0; i < off_mm.size(); ++i) {
    if (!counts(r.pieces()[i])) continue;
    const double off = std::fabs(off_mm[i]);
    sum += r.pieces()[i].area_m2 * off, square += r.pieces()[i].area_m2 * off * off;
  }
  if (!(sum > 0)) return false;
  std::vector<size_t> lobes[2];
  for (size_t i = 0; i < off_mm.size(); ++i) {
    if (counts(r.pieces()[i]) && std::fabs(off_mm[i]) > kMoved * square / sum)
      lobes[off_mm[i] > 0].push_back(i);
  }
  return std::ranges::all_of(lobes, [&](const std::vector<size_t>& pieces) {
    Components parts(pieces.size());
    for (size_t a = 0; a < pieces.size(); ++a) {
      for (size_t b = 0; b < a; ++b) {
        const dvec3 way = (r.pieces()[pieces[a]].at_m - r.pieces()[pieces[b]].at_m) * kMm;
        if (Dot(way, way) < kConnected_mm * kConnected_mm) parts.Join(a, b);
      }
    }
    // A lobe is more than a piece.
    std::map<size_t, int> sizes;
    for (size_t a = 0; a < pieces.size(); ++a) ++sizes[parts.Of(a)];
    return std::ranges::count_if(sizes, [](const auto& e) { return e.second > 2; }) >= kTwice;
  });
}

double LengthOverWidth(const AcceptableCut& r, const std::vector<double>& d_mm,
                       const dvec3& middle_m) {
  glm::dmat3 moments(0.0);
  double weights = 0;
  for (size_t i = 0; i < d_mm.size(); ++i) {
    const double weight = std::fabs(d_mm[i]) * r.pieces()[i].area_m2;
    const dvec3 out = (r.pieces()[i].at_m - middle_m) * kMm;
    weights += weight;
    for (int a = 0; a < 3; ++a) moments[a] += weight * out[a] * out;
  }
  if (!(weights > 0)) return 1;
  // Power iteration, twice: 20 steps are enough for a ratio that is compared with 2.
  auto largest = [](glm::dmat3& of) {
    dvec3 v(1, 0.7, 0.4);
    double value = 0;
    for (int i = 0; i < 20; ++i) {
      const dvec3 next = of * v;
      value = std::sqrt(Dot(next, next));
      if (!(value > 0)) return 0.0;
      v = next / value;
    }
    for (int a = 0; a < 3; ++a) of[a] -= value * v[a] * v;
    return value;
  };
  const double first = largest(moments), second = largest(moments);
  return second > 0 ? std::sqrt(first / second) : 1;
}

}  // namespace enamel::scoring
