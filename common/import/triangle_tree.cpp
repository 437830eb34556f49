#include "common/import/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace enamel::import {
namespace {

constexpr uint32_t kLeaf = 4;
constexpr int kMaxDepth = 60;
constexpr double kOpening = 2;

double Square(const dvec3& v) { return Dot(v, v); }

double SquareToSegment(const dvec3& p, const dvec3& a, const dvec3& b) {
  dvec3 ab = b - a;
  double n = Square(ab);
  double t = n > 0 ? std::clamp(Dot(p - a, ab) / n, 0.0, 1.0) : 0.0;
  return Square(p - a - t * ab);
}

double SquareToTriangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
  dvec3 n = glm::cross(b - a, c - a);
  double nn = Square(n);
  if (nn > 0) {
    // Inside the prism over the triangle the foot of the perpendicular is the nearest point.
    bool over = Dot(glm::cross(b - a, p - a), n) >= 0 && Dot(glm::cross(c - b, p - b), n) >= 0 &&
                Dot(glm::cross(a - c, p - c), n) >= 0;
    if (over) {
      double d = Dot(p - a, n);
      return d * d / nn;
    }
  }
  return std::min({SquareToSegment(p, a, b), SquareToSegment(p, b, c), SquareToSegment(p, c, a)});
}

double SquareToBox(const dvec3& p, const dvec3& lo, const dvec3& hi) {
  return Square(glm::max(glm::max(lo - p, p - hi), dvec3(0)));
}

// Van Oosterom and Strackee 1983.
double SolidAngle(const dvec3& p, dvec3 a, dvec3 b, dvec3 c) {
  a -= p, b -= p, c -= p;
  double la = std::sqrt(Square(a)), lb = std::sqrt(Square(b)), lc = std::sqrt(Square(c));
  double over = Dot(a, glm::cross(b, c));
  double under = la * lb * lc + Dot(a, b) * lc + Dot(b, c) * la + Dot(c, a) * lb;
  return 2 * std::atan2(over, under);
}

}  // namespace

TriangleTree::TriangleTree(const Triangles& mesh) {
  std::vector<Triangle> all;
  for (const auto& t : mesh.indices) {
    all.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  }
  std::vector<uint32_t> order(all.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  nodes_.reserve(all.size());
  if (!all.empty()) Build(order, 0, static_cast<uint32_t>(all.size()), all, 0);
  for (uint32_t i : order) triangles_.push_back(all[i]);
}

void TriangleTree::Build(std::vector<uint32_t>& order, uint32_t first, uint32_t count,
                         const std::vector<Triangle>& all, int depth) {
  Node node;
  node.lo = dvec3(std::numeric_limits<double>::max());
  node.hi = -node.lo;
  node.first = first;
  double area_sum = 0;
  for (uint32_t i = first; i < first + count; ++i) {
    const Triangle& t = all[order[i]];
    node.lo = glm::min(node.lo, glm::min(t.a, glm::min(t.b, t.c)));
    node.hi = glm::max(node.hi, glm::max(t.a, glm::max(t.b, t.c)));
    dvec3 area = 0.5 * glm::cross(t.b - t.a, t.c - t.a);
    double size = std::sqrt(Square(area));
    node.area += area;
    node.centre += size / 3 * (t.a + t.b + t.c);
    area_sum += size;
  }
  node.centre = area_sum > 0 ? node.centre / area_sum : 0.5 * (node.lo + node.hi);
  node.radius = std::sqrt(Square(glm::max(node.hi - node.centre, node.centre - node.lo)));
  const size_t self = nodes_.size();
  bool leaf = count <= kLeaf || depth >= kMaxDepth;
  node.count = leaf ? count : 0;
  nodes_.push_back(node);
  if (leaf) return;
  dvec3 size = node.hi - node.lo;
  int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  auto middle = [&](uint32_t i) { return all[i].a[axis] + all[i].b[axis] + all[i].c[axis]; };
  uint32_t half = count / 2;
  std::nth_element(order.begin() + first, order.begin() + first + half,
                   order.begin() + first + count, [&](uint32_t l, uint32_t r) {
                     return middle(l) != middle(r) ? middle(l) < middle(r) : l < r;
                   });
  Build(order, first, half, all, depth + 1);
  nodes_[self].right = static_cast<uint32_t>(nodes_.size());
  Build(order, first + half, count - half, all, depth + 1);
}

double TriangleTree::Distance(const dvec3& p, double limit) const {
  if (nodes_.empty()) return limit;
  double best = limit * limit;
  struct Entry {
    uint32_t node;
    double square;
  };
  Entry stack[2 * kMaxDepth + 4];
  int top = 0;
  stack[top++] = {0, SquareToBox(p, nodes_[0].lo, nodes_[0].hi)};
  while (top > 0) {
    Entry e = stack[--top];
    if (e.square >= best) continue;
    const Node& node = nodes_[e.node];
    if (node.count > 0) {
      for (uint32_t i = node.first; i < node.first + node.count; ++i) {
        best =
            std::min(best, SquareToTriangle(p, triangles_[i].a, triangles_[i].b, triangles_[i].c));
      }
      continue;
    }
    Entry l{e.node + 1, SquareToBox(p, nodes_[e.node + 1].lo, nodes_[e.node + 1].hi)};
    Entry r{node.right, SquareToBox(p, nodes_[node.right].lo, nodes_[node.right].hi)};
    if (l.square < r.square) std::swap(l, r);
    stack[top++] = l;  // the nearer one is looked at first
    stack[top++] = r;
  }
  return std::sqrt(best);
}

double TriangleTree::Winding(const dvec3& p) const {
  if (nodes_.empty()) return 0;
  double sum = 0;
  uint32_t stack[2 * kMaxDepth + 4];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    uint32_t at = stack[--top];
    const Node& node = nodes_[at];
    dvec3 r = node.centre - p;
    double rr = Square(r);
    if (rr > kOpening * kOpening * node.radius * node.radius) {
      sum += Dot(node.area, r) / (rr * std::sqrt(rr));
    } else if (node.count > 0) {
      for (uint32_t i = node.first; i < node.first + node.count; ++i) {
        sum += SolidAngle(p, triangles_[i].a, triangles_[i].b, triangles_[i].c);
      }
    } else {
      stack[top++] = at + 1;
      stack[top++] = node.right;
    }
  }
  return sum / (4 * std::numbers::pi);
}

double SignedProbe::Distance(const dvec3& p, double limit) {
  double moved = known_ ? std::sqrt(Square(p - last_)) : 0;
  // The last point's nearest triangle is at most this far from here.
  double bound = limit;
  if (last_found_) bound = std::min(limit, (moved + last_distance_) * (1 + 1e-9) + 1e-12);
  double d = surface_->Distance(p, bound);
  bool same_side = known_ && moved < std::max(d, last_distance_) * (1 - 1e-9);
  bool inside = same_side ? last_inside_ : solid_->Winding(p) > 0.5;
  known_ = true;
  last_ = p;
  last_distance_ = d;
  last_found_ = d < limit;
  last_inside_ = inside;
  return inside ? -d : d;
}

}  // namespace enamel::import
