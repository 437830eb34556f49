#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/cutting/volume.h"
#include "common/math/vec.h"

// The volume's surface as triangles, by surface nets (Gibson 1998): one vertex per grid cell that
// the zero level crosses, at the mean of its edge crossings; one quad per crossed grid edge, split
// along its shorter diagonal. Closed and oriented outward; no cracks between bricks, because a cell
// belongs to one brick and reads its neighbours. What lies outside the grid counts as air, so solid
// that touches the border is closed there too.
//
// Every directed edge is matched by one in the opposite direction. Where two sheets of the surface
// pass through one cell (a wall thinner than a voxel) they share its vertex, and an edge may then
// carry four triangles instead of two.
//
// A plane is met exactly (to the fixed point's 1/8192 voxel); on a sphere of radius R voxels the
// vertices lie inside by up to about 0.5 / R voxel.
namespace enamel::surface {

struct Mesh {
  std::vector<glm::vec3> position_m;  // (n x 3), scene frame
  std::vector<glm::vec3> normal;      // (n x 3), unit, outward, from the gradient in its cell
  std::vector<uint8_t> tissue;        // (n), cutting::Tissue just under the surface
  std::vector<std::array<uint32_t, 3>> triangles;  // counter-clockwise seen from outside
};

// Whole surface. Deterministic: equal volumes give equal meshes. `cells`: also gets the grid cell of
// each vertex, named by its first sample; below 0 where the surface closes the grid. Not real-time.
// Thread safety: reads the volume only.
Mesh ExtractSurface(const cutting::Volume& volume, std::vector<ivec3>* cells = nullptr);

// A normal for pictures, at a point in sample coordinates: the direction of the gradient of a cubic
// B-spline over the 64 samples around it, which count as at most a voxel away, as in a timeline.
// `otherwise` where the gradient vanishes. Along the edge of two walls at right angles it leans at most
// 8 degrees to either end of the edge. A normal of Mesh, which knows one cell, leans up to 40, and light
// shows facets. On balls from 3 voxels and on planes it is off by at most 2 degrees.
glm::vec3 SmoothNormal(const cutting::Volume& volume, const dvec3& sample,
                       const glm::vec3& otherwise);
// The SmoothNormal of each vertex of the volume's mesh.
std::vector<glm::vec3> SmoothNormals(const cutting::Volume& volume, const Mesh& mesh);

// Only the quads of the edges that start in this brick, with vertices of their own (those on the
// brick's lower faces are repeated by its neighbours): for incremental display. The parts of all
// bricks together make the same triangles, at bit-equal positions, as ExtractSurface. Reads samples
// up to one voxel outside the brick: after a change, extract the brick and its 26 neighbours.
// Requires: 0 <= brick < brick_count.
Mesh ExtractBrick(const cutting::Volume& volume, int brick);

// Area (m^2) and enclosed volume (m^3; divergence theorem, so only for closed meshes).
double Area_m2(const Mesh& mesh);
double EnclosedVolume_m3(const Mesh& mesh);

// Unsigned distance from points to a mesh, in a uniform grid of triangles.
// Copies what it needs of the mesh. Thread safety: const after construction. Not real-time.
class DistanceQuery {
 public:
  explicit DistanceQuery(const Mesh& mesh);
  // Of the triangles whose bounding boxes meet the box only.
  DistanceQuery(const Mesh& mesh, const dvec3& lo_m, const dvec3& hi_m);
  // Distance in metres to the nearest triangle, at most `limit_m`; `limit_m` for an empty mesh or a
  // point that is not finite. Exact. Time grows with the distance found, in cells.
  double Distance_m(const dvec3& point_m, double limit_m) const;
  // The nearest triangle, counted among those taken from the mesh; none at `limit_m` or farther. Of
  // equally near ones always the same. `guess`: a triangle of the mesh that may be near, such as the answer for a
  // neighbouring point. A guess speeds the search up and never changes the answer.
  struct Nearest {
    double distance_m = 0;
    uint32_t triangle = 0;
  };
  static constexpr uint32_t kNone = 0xffffffff;
  std::optional<Nearest> NearestTriangle(const dvec3& point_m, double limit_m,
                                         uint32_t guess = kNone) const;
  // Requires: a triangle that NearestTriangle named.
  double DistanceTo_m(uint32_t triangle, const dvec3& point_m) const;
  // Whether Distance_m is at most `distance_m`, quicker: it stops at the first triangle near
  // enough. False for an empty mesh or a point that is not finite.
  bool IsWithin(const dvec3& point_m, double distance_m) const;

 private:
  // Around a triangle. Most are ruled out by it.
  struct Ball {
    dvec3 centre_m;
    double radius_m;
  };
  struct Found {
    double distance2 = 0;
    uint32_t triangle = kNone;
  };
  // Square of the distance where that is below `limit2`, else `limit2` and kNone. Ends at the first
  // triangle whose distance is at most `enough_m`.
  Found Nearest2(const dvec3& point_m, double limit2, double enough_m,
                 uint32_t guess = kNone) const;

  std::vector<std::array<dvec3, 3>> triangles_;
  std::vector<Ball> balls_;
  dvec3 origin_{0};
  double cell_m_ = 0;
  ivec3 size_{0};
  std::vector<uint32_t> first_;  // (cells + 1): start in items_
  std::vector<uint32_t> items_;  // triangle indices
};

}  // namespace enamel::surface
