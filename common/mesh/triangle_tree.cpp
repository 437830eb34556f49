#include "common/mesh/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace enamel::mesh {
namespace {

// kMaxDepth only sizes the stacks: halving brings two million triangles down in 20 levels. kOpening
// is that of Barill and others, Fast Winding Numbers for Soups and Clouds (ACM Transactions on
// Graphics 37, 2018), whose dipoles stand for far groups here.
constexpr uint32_t kLeaf = 4;
constexpr int kMaxDepth = 60;
constexpr double kOpening = 2;

double Square(const dvec3& v) { return Dot(v, v); }

double SquareToSegment(const dvec3& ap, const dvec3& ab) {
  double n = Square(ab);
  double t = n > 0 ? std::clamp(Dot(ap, ab) / n, 0.0, 1.0) : 0.0;
  return Square(ap - t * ab);
}

dvec3 NearestOnSegment(const dvec3& p, const dvec3& a, const dvec3& b) {
  const double n = Square(b - a);
  return a + (n > 0 ? std::clamp(Dot(p - a, b - a) / n, 0.0, 1.0) : 0.0) * (b - a);
}

// The foot of the perpendicular is a + s u + t v with u, v the edges at a; outside the triangle
// the nearest point is on an edge.
double SquareToTriangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
  const dvec3 u = b - a, v = c - a, w = p - a;
  double uu = Dot(u, u), uv = Dot(u, v), vv = Dot(v, v), uw = Dot(u, w), vw = Dot(v, w);
  double det = uu * vv - uv * uv;
  double s = vv * uw - uv * vw, t = uu * vw - uv * uw;
  if (det > 0 && s >= 0 && t >= 0 && s + t <= det) return Square(w - (s / det) * u - (t / det) * v);
  return std::min({SquareToSegment(w, u), SquareToSegment(w, v), SquareToSegment(p - b, c - b)});
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

TriangleTree::Triangle TriangleTree::WithSphere(const dvec3& a, const dvec3& b, const dvec3& c) {
  dvec3 middle = (a + b + c) / 3.0;
  return {a, b, c, middle,
          std::sqrt(std::max({Square(a - middle), Square(b - middle), Square(c - middle)}))};
}

TriangleTree::TriangleTree(const Triangles& mesh) {
  std::vector<Triangle> all;
  all.reserve(mesh.indices.size());
  for (const auto& t : mesh.indices) {
    all.push_back(WithSphere(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
  }
  std::vector<uint32_t> order(all.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  nodes_.reserve(all.size());
  if (!all.empty()) Build(order, 0, static_cast<uint32_t>(all.size()), all, 0);
  triangles_.reserve(all.size());
  for (uint32_t i : order) triangles_.push_back(all[i]);
  source_ = std::move(order);
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
                     // Equal places by number: the tree, and so every distance's last bit, does not
                     // depend on the library.
                     return middle(l) != middle(r) ? middle(l) < middle(r) : l < r;
                   });
  Build(order, first, half, all, depth + 1);
  nodes_[self].right = static_cast<uint32_t>(nodes_.size());
  Build(order, first + half, count - half, all, depth + 1);
}

double TriangleTree::Distance(const dvec3& p, double limit, uint32_t* nearest) const {
  if (nodes_.empty()) return limit;
  double best = limit, best_square = limit * limit;
  uint32_t found = nearest != nullptr && *nearest < triangles_.size() ? *nearest : 0;
  auto look = [&](uint32_t i) {
    const Triangle& t = triangles_[i];
    double reach = best + t.radius;
    if (Square(p - t.middle) >= reach * reach) return;
    double square = SquareToTriangle(p, t.a, t.b, t.c);
    if (square >= best_square) return;
    best_square = square;
    best = std::sqrt(square);
    found = i;
  };
  // The guess first: its distance prunes most of the tree.
  look(found);
  struct Entry {
    uint32_t node;
    double square;
  };
  Entry stack[2 * kMaxDepth + 4];
  int top = 0;
  stack[top++] = {0, SquareToBox(p, nodes_[0].lo, nodes_[0].hi)};
  while (top > 0) {
    Entry e = stack[--top];
    if (e.square >= best_square) continue;
    const Node& node = nodes_[e.node];
    if (node.count > 0) {
      for (uint32_t i = node.first; i < node.first + node.count; ++i) look(i);
      continue;
    }
    Entry l{e.node + 1, SquareToBox(p, nodes_[e.node + 1].lo, nodes_[e.node + 1].hi)};
    Entry r{node.right, SquareToBox(p, nodes_[node.right].lo, nodes_[node.right].hi)};
    if (l.square < r.square) std::swap(l, r);
    stack[top++] = l;  // the nearer one is looked at first
    stack[top++] = r;
  }
  if (nearest != nullptr) *nearest = found;
  return best;
}

dvec3 TriangleTree::NearestOn(uint32_t triangle, const dvec3& p) const {
  const Triangle& t = triangles_[triangle];
  const dvec3 n = glm::cross(t.b - t.a, t.c - t.a);
  const double square = Square(n);
  const dvec3 corners[3] = {t.a, t.b, t.c};
  bool over = square > 0;
  dvec3 nearest = t.a;
  for (int k = 0; k < 3; ++k) {
    const dvec3 &a = corners[k], &b = corners[(k + 1) % 3];
    over = over && Dot(glm::cross(n, b - a), p - a) >= 0;
    const dvec3 q = NearestOnSegment(p, a, b);
    if (Square(p - q) < Square(p - nearest)) nearest = q;
  }
  return over ? p - (Dot(p - t.a, n) / square) * n : nearest;
}

void TriangleTree::Collect(const dvec3& lo, const dvec3& hi, std::vector<uint32_t>& out) const {
  out.clear();
  if (nodes_.empty()) return;
  auto meets = [&](const dvec3& l, const dvec3& h) {
    return l.x <= hi.x && h.x >= lo.x && l.y <= hi.y && h.y >= lo.y && l.z <= hi.z && h.z >= lo.z;
  };
  uint32_t stack[2 * kMaxDepth + 4];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const uint32_t at = stack[--top];
    const Node& node = nodes_[at];
    if (!meets(node.lo, node.hi)) continue;
    if (node.count == 0) {
      stack[top++] = node.right;
      stack[top++] = at + 1;
      continue;
    }
    for (uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Triangle& t = triangles_[i];
      if (meets(glm::min(t.a, glm::min(t.b, t.c)), glm::max(t.a, glm::max(t.b, t.c))))
        out.push_back(i);
    }
  }
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
  double d = surface_->Distance(p, limit, &nearest_);
  double moved = known_ ? std::sqrt(Square(p - last_)) : 0;
  // Within d of a point there is no surface, so nothing parts it from points nearer than that.
  bool same_side = known_ && moved < std::max(d, last_distance_) * (1 - 1e-9);
  bool inside = same_side ? last_inside_ : solid_->Inside(p);
  known_ = true;
  last_ = p;
  last_distance_ = d;
  last_inside_ = inside;
  return inside ? -d : d;
}

}  // namespace enamel::mesh
