#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/cutting/tissue.h"
#include "common/mesh/mesh_repair.h"
#include "common/mesh/triangle_tree.h"
#include "common/scene/builder.h"

// A tooth from one surface per tissue. The surfaces come from different segmentations: where two
// tissues meet they cross and gape by some hundredths of a millimetre. That must leave no air
// between them, and nothing of one within the other.
//
// Solid is what is inside any of the surfaces or in a cleft between two: outside all, with
// distances to both that are together no more than the bridge, and their nearest points on opposite
// sides (over 96 degrees apart), or one straight ahead when coming from the other. The tissue
// there:
// - side by side (face to face within 0.5 mm over a tenth of the smaller surface, as an enamel
//   shell on dentin): the one that the point lies deeper in, so that a crossing is parted in its
//   middle;
// - else nested (sharing a tenth of the smaller volume): the inner one's, pulp before dentin before
//   enamel; pulp is pulp wherever it crosses enamel;
// - in a cleft: the nearer one's, also where both sides lie within an enamel dome;
// - between the cap that closes an open enamel dome and dentin within a millimetre across from it:
//   dentin's.
namespace enamel::import {

enum class Layer : size_t { kEnamel, kDentin, kPulp };
inline constexpr size_t kLayers = 3;
inline constexpr std::array<cutting::Tissue, kLayers> kLayerTissues = {
    cutting::Tissue::kEnamel, cutting::Tissue::kDentin, cutting::Tissue::kPulp};

struct LayerOptions {
  double bridge_mm = 0.1;
  double finest_mm = 0.01;  // as in mesh::RepairOptions
};

// One closed solid per tissue, by Layer, and what was done about them.
struct LayerSolids {
  std::array<std::optional<mesh::Solid>, kLayers> solids;
  std::vector<std::string> report;
};

// Repairs each surface on its own (mesh_repair.h); millimetres, any common frame. A hollow in the
// dentin is the pulp where no pulp is given. Errors: kInvalidInput, the message begins with the
// tissue: no dentin, nothing but dentin, no solid, or not of one tooth with the dentin (extents
// more than 30 times different, or bounding boxes apart: another unit or frame).
Result<LayerSolids> RepairLayers(
    const std::array<std::optional<mesh::Triangles>, kLayers>& surfaces_mm,
    const LayerOptions& options);

// From the middle of the dentin's surface to the middle of the enamel's: the way a crown points.
// Its length tells how sure that is. Zero without enamel.
dvec3 RiseOf(const LayerSolids& layers);

// Thread safety: const after construction.
class LayeredTooth {
 public:
  // Cosine between the ways to both sides of a cleft, at most.
  static constexpr double kOpposite = -0.1;

  // Errors: kInvalidInput when two surfaces that should be side by side do not meet, or more than 2
  // % of where they meet gapes or crosses by more than the bridge; the message gives the figure.
  static Result<LayeredTooth> Make(LayerSolids layers, const LayerOptions& options);

  // Signed distances to each tissue's own surface, cut off at +-reach; +reach where there is none.
  struct Distances {
    std::array<double, kLayers> to;
    double reach;
  };
  bool Inside(const dvec3& p, const Distances& d) const;
  // Requires: reach at least the bridge. kAir when no tissue is within reach.
  cutting::Tissue TissueAt(const dvec3& p, const Distances& d) const;
  double bridge() const { return bridge_; }

  // Pieces of all surfaces with air before them: the surface of the tooth.
  const mesh::TriangleTree& boundary() const { return *boundary_; }

  // One tissue's surface, for distances, and its closed mesh, for sides.
  struct Surface {
    mesh::Solid solid;
    mesh::TriangleTree boundary, whole;
    mesh::TriangleTree own, caps;  // triangles of the file; of holes that were closed
  };
  const Surface* surface(size_t layer) const { return surfaces_[layer].get(); }
  // One line each, for people.
  const std::vector<std::string>& report() const { return report_; }

 private:
  // Where surfaces are face to face: gaps positive, crossings negative.
  struct Meeting {
    double own_mm2 = 0, area_mm2 = 0, beyond_mm2 = 0, gap_mm = 0, crossing_mm = 0;
  };
  double SharedVolume(size_t outer, size_t inner) const;
  Meeting Measure(size_t outer, size_t inner) const;
  Status FindRelation(Layer outer, Layer inner);
  void FindBoundary(double finest_mm);  // layer_boundary.cpp
  void ReportPulpOutside();
  std::optional<size_t> NearerOfCleft(const dvec3& p, const Distances& d) const;
  bool IsBehindCap(const dvec3& p) const;

  std::array<std::unique_ptr<Surface>, kLayers> surfaces_;
  std::unique_ptr<mesh::TriangleTree> boundary_;
  std::array<std::array<bool, kLayers>, kLayers> nested_{};  // [outer][inner]
  double bridge_ = 0;
  std::vector<std::string> report_;
};

// The probe and the field are in layer_field.cpp.

// Distances at points visited one near the other. One per thread.
class LayerProbe {
 public:
  explicit LayerProbe(const LayeredTooth& tooth);
  LayeredTooth::Distances At(const dvec3& p, double reach);
  // To the tooth's surface, negative inside, magnitude at most `limit`.
  double Distance(const dvec3& p, double limit);

 private:
  const LayeredTooth* tooth_;
  std::array<std::optional<mesh::SignedProbe>, kLayers> probes_;
  uint32_t nearest_ = 0;
};

// The tooth for BuildVolume, whose frame in metres is the solids' frame; one per thread.
std::unique_ptr<scene::BrickField> MakeLayerField(const LayeredTooth& tooth);

}  // namespace enamel::import
