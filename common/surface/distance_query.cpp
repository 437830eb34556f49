#include <algorithm>
#include <cmath>
#include <limits>

#include "common/surface/surface.h"

namespace enamel::surface {
namespace {

constexpr double kMaxCells = 4e6;
// Bounds that rule a triangle out are wider by more than rounding can take from them, so that they
// never change an answer.
constexpr double kRoundUp = 1 + 1e-12;

dvec3 Lowest(const std::array<dvec3, 3>& t) { return glm::min(glm::min(t[0], t[1]), t[2]); }
dvec3 Highest(const std::array<dvec3, 3>& t) { return glm::max(glm::max(t[0], t[1]), t[2]); }

double SegmentDistance2(const dvec3& p, const dvec3& a, const dvec3& b) {
  dvec3 ab = b - a, ap = p - a;
  double length2 = Dot(ab, ab);
  double t = length2 > 0 ? std::clamp(Dot(ap, ab) / length2, 0.0, 1.0) : 0.0;
  dvec3 d = ap - t * ab;
  return Dot(d, d);
}

double TriangleDistance2(const dvec3& p, const std::array<dvec3, 3>& t) {
  dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
  double n2 = Dot(n, n);
  bool over = n2 > 0;
  for (size_t i = 0; i < 3 && over; ++i) {
    const dvec3 &a = t[i], &b = t[(i + 1) % 3];
    over = Dot(glm::cross(b - a, p - a), n) >= 0;
  }
  if (over) {
    double h = Dot(p - t[0], n);
    return h * h / n2;
  }
  return std::min({SegmentDistance2(p, t[0], t[1]), SegmentDistance2(p, t[1], t[2]),
                   SegmentDistance2(p, t[2], t[0])});
}

ivec3 CellOf(const dvec3& g) {
  return ivec3(static_cast<int>(std::floor(g.x)), static_cast<int>(std::floor(g.y)),
               static_cast<int>(std::floor(g.z)));
}

// The same for what has no negative component; floor is a call of its own on older processors.
ivec3 CellInside(const dvec3& g) {
  return ivec3(static_cast<int>(g.x), static_cast<int>(g.y), static_cast<int>(g.z));
}

// Calls visit(cell) for the cells of the grid at Chebyshev distance `ring` from `centre`.
template <typename Visit>
void VisitRing(const ivec3& centre, int ring, const ivec3& size, Visit&& visit) {
  ivec3 lo = glm::max(centre - ring, ivec3(0)), hi = glm::min(centre + ring, size - 1);
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      bool face = std::abs(z - centre.z) == ring || std::abs(y - centre.y) == ring;
      if (face) {
        for (int x = lo.x; x <= hi.x; ++x) visit(ivec3(x, y, z));
        continue;
      }
      if (centre.x - ring >= lo.x) visit(ivec3(centre.x - ring, y, z));
      if (centre.x + ring <= hi.x) visit(ivec3(centre.x + ring, y, z));
    }
  }
}

}  // namespace

DistanceQuery::DistanceQuery(const Mesh& mesh)
    : DistanceQuery(mesh, dvec3(-std::numeric_limits<double>::infinity()),
                    dvec3(std::numeric_limits<double>::infinity())) {}

DistanceQuery::DistanceQuery(const Mesh& mesh, const dvec3& lo_m, const dvec3& hi_m) {
  dvec3 lo(1e300), hi(-1e300);
  double edges = 0;
  for (const auto& t : mesh.triangles) {
    const std::array<dvec3, 3> corners = {
        dvec3(mesh.position_m[t[0]]), dvec3(mesh.position_m[t[1]]), dvec3(mesh.position_m[t[2]])};
    const dvec3 from = Lowest(corners), to = Highest(corners);
    if (glm::any(glm::lessThan(to, lo_m)) || glm::any(glm::lessThan(hi_m, from))) continue;
    triangles_.push_back(corners);
    lo = glm::min(lo, from);
    hi = glm::max(hi, to);
    edges += glm::length(corners[1] - corners[0]);
  }
  if (triangles_.empty()) return;
  dvec3 extent = glm::max(hi - lo, dvec3(1e-9));
  origin_ = lo;
  // Three mean edges: a few triangles in a cell, most of them ruled out by their balls. Larger
  // where that would be too many cells.
  cell_m_ = std::max(3 * edges / static_cast<double>(triangles_.size()),
                     std::cbrt(extent.x * extent.y * extent.z / kMaxCells));
  cell_m_ = std::max(cell_m_, std::max({extent.x, extent.y, extent.z}) / 2048);
  size_ = CellOf(extent / cell_m_) + 1;

  balls_.reserve(triangles_.size());
  for (const auto& t : triangles_) {
    const dvec3 middle = (Lowest(t) + Highest(t)) * 0.5;
    double radius2 = 0;
    for (const dvec3& corner : t)
      radius2 = std::max(radius2, Dot(corner - middle, corner - middle));
    balls_.push_back({middle, std::sqrt(radius2) * kRoundUp});
  }

  auto for_each_cell = [&](uint32_t triangle, auto&& visit) {
    const auto& t = triangles_[triangle];
    ivec3 first = glm::min(CellInside((Lowest(t) - origin_) / cell_m_), size_ - 1);
    ivec3 last = glm::min(CellInside((Highest(t) - origin_) / cell_m_), size_ - 1);
    for (int z = first.z; z <= last.z; ++z)
      for (int y = first.y; y <= last.y; ++y)
        for (int x = first.x; x <= last.x; ++x)
          visit((static_cast<size_t>(z) * size_.y + y) * size_.x + x);
  };
  first_.assign(static_cast<size_t>(size_.x) * size_.y * size_.z + 1, 0);
  auto count = static_cast<uint32_t>(triangles_.size());
  for (uint32_t i = 0; i < count; ++i) for_each_cell(i, [&](size_t cell) { ++first_[cell + 1]; });
  for (size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  items_.resize(first_.back());
  std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
  for (uint32_t i = 0; i < count; ++i)
    for_each_cell(i, [&](size_t cell) { items_[next[cell]++] = i; });
}

double DistanceQuery::Distance_m(const dvec3& point_m, double limit_m) const {
  return std::sqrt(Nearest2(point_m, limit_m * limit_m, 0).distance2);
}

bool DistanceQuery::IsWithin(const dvec3& point_m, double distance_m) const {
  // A little farther, so that a triangle at exactly this distance is found and counts as within.
  const double limit = distance_m * kRoundUp + 1e-12;
  return std::sqrt(Nearest2(point_m, limit * limit, distance_m).distance2) <= distance_m;
}

std::optional<DistanceQuery::Nearest> DistanceQuery::NearestTriangle(const dvec3& point_m,
                                                                     double limit_m,
                                                                     uint32_t guess) const {
  const Found found = Nearest2(point_m, limit_m * limit_m, 0, guess);
  if (found.triangle == kNone) return {};
  return Nearest{std::sqrt(found.distance2), found.triangle};
}

double DistanceQuery::DistanceTo_m(uint32_t triangle, const dvec3& point_m) const {
  return std::sqrt(TriangleDistance2(point_m, triangles_[triangle]));
}

DistanceQuery::Found DistanceQuery::Nearest2(const dvec3& point_m, double limit2, double enough_m,
                                             uint32_t guess) const {
  dvec3 g = (point_m - origin_) / cell_m_;
  bool near = std::fabs(g.x) < 1e6 && std::fabs(g.y) < 1e6 && std::fabs(g.z) < 1e6;
  if (triangles_.empty() || !near) return {limit2};
  ivec3 centre = CellOf(g);
  // Rings that do not reach the grid are skipped; those past its far side hold nothing.
  ivec3 before = glm::max(-centre, centre - (size_ - 1));
  ivec3 beyond = glm::max(centre, size_ - 1 - centre);
  int ring = std::max({0, before.x, before.y, before.z});
  int last = std::max({beyond.x, beyond.y, beyond.z});
  // From the point to the nearest side of its own cell, in cells.
  dvec3 f = g - dvec3(centre), to_side = glm::min(f, 1.0 - f);
  double margin = std::min({to_side.x, to_side.y, to_side.z});
  uint32_t nearest_one = kNone;
  double best2 = limit2;
  if (guess != kNone) {
    // A little farther than it is, so that it is found in its turn: of equally near ones the first counts.
    constexpr double kFarther = 1 + 1e-9, kMin2 = 1e-30;
    best2 = std::min(best2, TriangleDistance2(point_m, triangles_[guess]) * kFarther + kMin2);
  }
  double best = std::sqrt(best2) * kRoundUp;
  for (; ring <= last; ++ring) {
    double nearest = ring == 0 ? 0 : (ring - 1 + margin) * cell_m_;
    if (nearest * nearest >= best2 || best <= enough_m) break;
    VisitRing(centre, ring, size_, [&](const ivec3& c) {
      size_t cell = (static_cast<size_t>(c.z) * size_.y + c.y) * size_.x + c.x;
      if (first_[cell] == first_[cell + 1]) return;
      dvec3 outside = glm::max(glm::max(dvec3(c) - g, g - dvec3(c) - 1.0), dvec3(0));
      if (Dot(outside, outside) * cell_m_ * cell_m_ >= best2) return;
      for (uint32_t i = first_[cell]; i < first_[cell + 1]; ++i) {
        const Ball& ball = balls_[items_[i]];
        const dvec3 d = point_m - ball.centre_m;
        const double reach = best + ball.radius_m;
        if (Dot(d, d) > reach * reach * kRoundUp) continue;
        const double d2 = TriangleDistance2(point_m, triangles_[items_[i]]);
        if (d2 >= best2) continue;
        best2 = d2;
        nearest_one = items_[i];
        best = std::sqrt(d2) * kRoundUp;
      }
    });
  }
  return {best2, nearest_one};
}

}  // namespace enamel::surface
