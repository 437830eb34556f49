#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/cutting/volume.h"
#include "common/math/vec.h"

// The volume's surface as triangles, by surface nets: one vertex per grid cell that the zero level
// crosses, at the mean of its edge crossings; one quad per crossed grid edge. Closed and oriented
// outward; no cracks between bricks, because a cell belongs to one brick and reads its neighbours.
namespace enamel::surface {

struct Mesh {
  std::vector<glm::vec3> position_m;     // (n x 3), scene frame
  std::vector<glm::vec3> normal;         // (n x 3), unit, outward, from the volume's gradient
  std::vector<uint8_t> tissue;           // (n), cutting::Tissue just under the surface
  std::vector<std::array<uint32_t, 3>> triangles;  // counter-clockwise seen from outside
};

// Whole surface. Not real-time. Thread safety: reads the volume only.
Mesh ExtractSurface(const cutting::Volume& volume);
// Only cells of these bricks, with vertices of their own: for incremental display. The parts of all
// bricks together make the same triangles as ExtractSurface.
Mesh ExtractBrick(const cutting::Volume& volume, int brick);

// Unsigned distance from points to a mesh, in a uniform grid of triangles.
// Thread safety: const after construction.
class DistanceQuery {
 public:
  explicit DistanceQuery(const Mesh& mesh);
  // Distance in metres to the nearest triangle, at most `limit_m`.
  double Distance_m(const dvec3& point_m, double limit_m) const;

 private:
  std::vector<std::array<dvec3, 3>> triangles_;
  dvec3 origin_{0};
  double cell_m_ = 0;
  ivec3 size_{0};
  std::vector<uint32_t> first_;          // (cells + 1): start in items_
  std::vector<uint32_t> items_;
};

}  // namespace enamel::surface
