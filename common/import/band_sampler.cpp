#include "common/import/band_sampler.h"

#include <algorithm>
#include <cmath>

namespace enamel::import {
namespace {

constexpr int kSide = cutting::kBrickSide;
using Row = std::array<float, kSide>;

struct fvec {
  float x, y, z;
};

fvec ToFloat(const dvec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

// An edge of a triangle: start, direction, 1 / length^2, and the normal in the plane that points
// away from the triangle.
struct EdgeLine {
  fvec at, along, outward;
  float over_square;
};

struct Facet {
  fvec middle;
  float radius;
  fvec corner, normal;  // unit normal, zero for a triangle without an area
  EdgeLine edge[3];
};

Facet Prepare(const mesh::TriangleTree::Triangle& t, const dvec3& origin) {
  const dvec3 corners[3] = {t.a - origin, t.b - origin, t.c - origin};
  dvec3 n = glm::cross(t.b - t.a, t.c - t.a);
  const double size = std::sqrt(Dot(n, n));
  n = size > 0 ? n / size : dvec3(0);
  Facet f{ToFloat(t.middle - origin),
          static_cast<float>(t.radius),
          ToFloat(corners[0]),
          ToFloat(n),
          {}};
  for (int k = 0; k < 3; ++k) {
    const dvec3 along = corners[(k + 1) % 3] - corners[k];
    const double square = Dot(along, along);
    f.edge[k] = {ToFloat(corners[k]), ToFloat(along), ToFloat(glm::cross(along, n)),
                 square > 0 ? static_cast<float>(1 / square) : 0};
  }
  return f;
}

// Squared distances of a row of points to a triangle: to its plane where all edges have the foot on
// their inner side, else to the nearest edge. Written for all eight at once, without branches.
void SquaresToFacet(const Facet& f, const Row& px, float py, float pz, Row& squares) {
  Row nearest, farthest_out;
  for (size_t i = 0; i < kSide; ++i) nearest[i] = 1e30f, farthest_out[i] = -1e30f;
  for (const EdgeLine& e : f.edge) {
    const float wy = py - e.at.y, wz = pz - e.at.z;
    const float along_yz = wy * e.along.y + wz * e.along.z;
    const float out_yz = wy * e.outward.y + wz * e.outward.z;
    for (size_t i = 0; i < kSide; ++i) {
      const float wx = px[i] - e.at.x;
      const float t = std::min(std::max((wx * e.along.x + along_yz) * e.over_square, 0.0f), 1.0f);
      const float dx = wx - t * e.along.x, dy = wy - t * e.along.y, dz = wz - t * e.along.z;
      nearest[i] = std::min(nearest[i], dx * dx + dy * dy + dz * dz);
      farthest_out[i] = std::max(farthest_out[i], wx * e.outward.x + out_yz);
    }
  }
  // A triangle without an area has no inner side; its edges are all there is.
  const bool flat = f.normal.x == 0 && f.normal.y == 0 && f.normal.z == 0;
  const float wy = py - f.corner.y, wz = pz - f.corner.z;
  const float plane_yz = wy * f.normal.y + wz * f.normal.z;
  for (size_t i = 0; i < kSide; ++i) {
    const float plane = (px[i] - f.corner.x) * f.normal.x + plane_yz;
    squares[i] = farthest_out[i] <= 0 && !flat ? plane * plane : nearest[i];
  }
}

// One row of the brick and the farthest that any of its samples still is from a triangle.
struct RowState {
  Row square;
  float farthest;
};

}  // namespace

void BandSampler::Distances(const dvec3& corner, double h, double limit, Samples& out) {
  const double half = 0.5 * h * (kSide - 1);
  const dvec3 middle = corner + half;
  tree_->Collect(corner - limit, corner + 2 * half + limit, near_);
  std::array<RowState, kSide * kSide> rows;
  const auto cap = static_cast<float>(limit);
  for (RowState& row : rows) row.square.fill(cap * cap), row.farthest = cap;
  Row at;
  for (int i = 0; i < kSide; ++i) at[static_cast<size_t>(i)] = static_cast<float>(i * h - half);
  const float edge = static_cast<float>(half);
  // In strides, so that the first few already lie near every row.
  const size_t n = near_.size(), stride = n > 16 ? 16 : 1;
  for (size_t from = 0; from < stride; ++from)
    for (size_t k = from; k < n; k += stride) {
      const Facet f = Prepare(tree_->At(near_[k]), middle);
      // Two bounds for the whole row, cheapest first: the sphere around the triangle, then its
      // plane.
      const float dx = std::max(std::abs(f.middle.x) - edge, 0.0f);
      for (size_t r = 0; r < rows.size(); ++r) {
        RowState& row = rows[r];
        const float y = at[r % kSide], z = at[r / kSide];
        const float reach = row.farthest + f.radius;
        const float dy = y - f.middle.y, dz = z - f.middle.z;
        if (dx * dx + dy * dy + dz * dz >= reach * reach) continue;
        const float off_plane = std::abs((y - f.corner.y) * f.normal.y +
                                         (z - f.corner.z) * f.normal.z - f.corner.x * f.normal.x);
        if (off_plane - edge * std::abs(f.normal.x) >= row.farthest) continue;
        Row squares;
        SquaresToFacet(f, at, y, z, squares);
        float farthest = 0;
        for (size_t i = 0; i < kSide; ++i) {
          row.square[i] = std::min(row.square[i], squares[i]);
          farthest = std::max(farthest, row.square[i]);
        }
        row.farthest = std::sqrt(farthest);
      }
    }
  for (size_t r = 0; r < rows.size(); ++r)
    for (size_t i = 0; i < kSide; ++i) out[r * kSide + i] = std::sqrt(rows[r].square[i]);
}

}  // namespace enamel::import
