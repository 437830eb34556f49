#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "common/mesh/triangles.h"

namespace enamel::mesh {

// Bounding-volume tree over triangles: nearest distance and winding number.
// Winding numbers: solid angles of near triangles, dipoles of far groups (first order, opened
// within twice a group's radius; error below 0.05 on closed meshes, judged against 0.5).
// Thread safety: const after construction.
class TriangleTree {
 public:
  explicit TriangleTree(const Triangles& mesh);

  bool empty() const { return triangles_.empty(); }
  uint32_t size() const { return static_cast<uint32_t>(triangles_.size()); }
  // Distance to the nearest triangle, or `limit` when none is nearer. `nearest` (may be null) is a
  // guess, in the tree's own numbering, that shortens the search, and becomes the triangle found.
  double Distance(const dvec3& p, double limit, uint32_t* nearest = nullptr) const;
  // The point of one triangle (the tree's own numbering) that is nearest to p.
  dvec3 NearestOn(uint32_t triangle, const dvec3& p) const;
  // How many times the mesh surrounds p: 0 outside, 1 inside a closed mesh oriented outward.
  double Winding(const dvec3& p) const;
  // Surrounded at least once, whichever way around.
  bool Inside(const dvec3& p) const { return std::abs(Winding(p)) > 0.5; }

  struct Triangle {
    dvec3 a, b, c;
    dvec3 middle{0};  // of a sphere around it
    double radius = 0;
  };
  // The triangles whose bounding boxes meet lo..hi, in the tree's own numbering.
  void Collect(const dvec3& lo, const dvec3& hi, std::vector<uint32_t>& out) const;
  const Triangle& At(uint32_t i) const { return triangles_[i]; }
  uint32_t SourceOf(uint32_t i) const { return source_[i]; }  // its index in the mesh

 private:
  struct Node {
    dvec3 lo, hi;
    dvec3 centre{0}, area{0};  // area-weighted centre; sum of area vectors
    double radius = 0;
    uint32_t first = 0, count = 0;  // leaf: triangles
    uint32_t right = 0;             // inner: left child is the next node
  };
  static Triangle WithSphere(const dvec3& a, const dvec3& b, const dvec3& c);
  void Build(std::vector<uint32_t>& order, uint32_t first, uint32_t count,
             const std::vector<Triangle>& all, int depth);

  std::vector<Triangle> triangles_;
  std::vector<uint32_t> source_;
  std::vector<Node> nodes_;
};

// Signed distance to `surface` of points visited one near the other: each search starts from the
// triangle found last. The side (winding number of `solid`) is computed again only when a surface
// may be in between. One per thread.
class SignedProbe {
 public:
  SignedProbe(const TriangleTree& surface, const TriangleTree& solid)
      : surface_(&surface), solid_(&solid) {}
  // Negative inside (TriangleTree::Inside); magnitude at most `limit`.
  double Distance(const dvec3& p, double limit);
  // The triangle found last, in the surface tree's numbering; meaningful when it was within limit.
  uint32_t nearest() const { return nearest_; }

 private:
  const TriangleTree* surface_;
  const TriangleTree* solid_;
  uint32_t nearest_ = 0;
  bool known_ = false;  // there was a last point
  dvec3 last_{0};
  double last_distance_ = 0;
  bool last_inside_ = false;
};

}  // namespace enamel::mesh
