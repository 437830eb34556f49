#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "common/base/result.h"
#include "common/import/place.h"
#include "common/mesh/triangle_tree.h"
#include "common/mesh/triangles.h"
#include "common/mesh/units.h"
#include "common/scene/builder.h"

// A scan of several teeth in one surface: one crown of it becomes the tooth, and crowns beside it its neighbours.
namespace enamel::import {

// Closed curves along gums, in mm along the file's axes (mesh::Jaw): first around the tooth, then around its neighbours.
using GumCurves = std::vector<std::vector<dvec3>>;
inline constexpr size_t kMaxGumCurves = 3;

struct CutCrowns {
  mesh::Triangles tooth;
  std::vector<mesh::Triangles> neighbours;
};
// Requires: at least one curve. Errors: as mesh::InMm and mesh::Jaw::Crown; kInvalidInput, field "around", where a crown has
// no tooth's size and where the curves are too many.
Result<CutCrowns> CutOut(const mesh::Triangles& scan, const mesh::FileScale& scale,
                         const GumCurves& around);

// A file of several teeth, read in the child, in mm, with joined vertices. Errors: ReadMeshInChild's, mesh::InMm's.
Result<mesh::Triangles> ReadJawScan(const std::filesystem::path& file, const mesh::FileScale& scale,
                                    const std::filesystem::path& child = {});

// A neighbour in the tooth's scene, closed where it was cut off. Thread safety: const after construction.
class NeighbourTooth {
 public:
  // Errors: kInvalidInput where it is no solid.
  static Result<std::unique_ptr<NeighbourTooth>> Make(const mesh::Triangles& crown,
                                                      const PlacedSolid& beside);
  const mesh::TriangleTree& boundary() const { return boundary_; }
  const mesh::TriangleTree& whole() const { return whole_; }
  const mesh::Box& box() const { return box_; }  // scene frame, mm

 private:
  explicit NeighbourTooth(const mesh::Solid& solid)
      : boundary_(solid.boundary), whole_(solid.mesh), box_(mesh::BoxOf(solid.mesh)) {}
  mesh::TriangleTree boundary_, whole_;
  mesh::Box box_;
};
using NeighbourTeeth = std::vector<std::unique_ptr<NeighbourTooth>>;

// The box of the tooth and of those parts of its neighbours that a bur at the tooth reaches.
mesh::Box BoxWith(const mesh::Box& tooth, const NeighbourTeeth& neighbours);
// The tooth's field with what of its neighbours is in the box (mm). Where both are, the tooth is.
std::unique_ptr<scene::BrickField> FieldWith(std::unique_ptr<scene::BrickField> tooth,
                                             const NeighbourTeeth& neighbours,
                                             const mesh::Box& box);

}  // namespace enamel::import
