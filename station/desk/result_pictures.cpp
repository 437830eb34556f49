#include "station/desk/result_pictures.h"

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "common/scene/preparation.h"
#include "common/scene/prepared_target.h"
#include "common/timeline/deviation.h"
#include "station/desk/desk_attempt.h"
#include "station/render/materials.h"

namespace enamel::station::desk {
namespace {

constexpr int kStill_px = 640;  // of a side

render::GroupMesh Whole(const surface::Mesh& mesh, std::span<const uint8_t> materials) {
  render::GroupMesh out;
  render::Append(mesh, materials, out);
  return out;
}

// How far it is off, by the cell that a vertex was made in.
class Cells {
 public:
  explicit Cells(const timeline::Deviation& deviation) : spec_(deviation.spec) {
    for (const timeline::CellDeviation& each : deviation.cells) {
      um_.emplace(KeyOf(each.cell), each.deviation_um);
    }
  }
  // A vertex nearer to its cell's border than positions are rounded may have been put into the
  // neighbouring one (schemas/surface_timeline.md, "Deviation").
  std::optional<double> At_mm(const glm::vec3& position_m) const {
    constexpr double kNearBorder = 1.0 / 16;
    const dvec3 at = (dvec3(position_m) - spec_.origin_m()) / spec_.voxel_m();
    const ivec3 cell(glm::floor(at));
    if (const auto found = um_.find(KeyOf(cell)); found != um_.end()) return 1e-3 * found->second;
    for (int axis = 0; axis < 3; ++axis) {
      const double in = at[axis] - cell[axis];
      if (in > kNearBorder && in < 1 - kNearBorder) continue;
      ivec3 across = cell;
      across[axis] += in > 0.5 ? 1 : -1;
      if (const auto found = um_.find(KeyOf(across)); found != um_.end()) {
        return 1e-3 * found->second;
      }
    }
    return std::nullopt;
  }

 private:
  // Of cells from -1 on; a grid has fewer than 2^20 on a side.
  static uint64_t KeyOf(const ivec3& cell) {
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      key = key << 21 | (static_cast<uint64_t>(cell[axis] + 2) & 0x1fffff);
    }
    return key;
  }

  const cutting::GridSpec spec_;
  std::unordered_map<uint64_t, int32_t> um_;
};

}  // namespace

Result<ResultSurfaces> SurfacesOf(LookBack& recording,
                                  const std::function<bool(double)>& keep_going) {
  ENAMEL_ASSIGN_OR_RETURN(auto end, recording.Take(UINT64_MAX, UINT64_MAX, keep_going));
  const PreparedAttempt& prepared = recording.prepared();
  ResultSurfaces out;
  out.camera = render::StillCamera(ViewOf(prepared), prepared.volume);
  const surface::Mesh before = surface::ExtractSurface(prepared.volume);
  out.before = Whole(before, before.tissue);
  out.after_surface = surface::ExtractSurface(end.core->volume().Unpacked());
  out.after = Whole(out.after_surface, out.after_surface.tissue);
  return out;
}

render::GroupMesh TargetSurface(const PreparedAttempt& prepared) {
  const scene::CavityTarget& target = prepared.exercise.target;
  if (target.prepared_tooth) {
    const surface::Mesh mesh = surface::ExtractSurface(target.prepared_tooth->volume);
    return Whole(mesh, mesh.tissue);
  }
  const auto shape = scene::TargetShape(prepared.scene, target);
  if (!shape.ok() || target.depth_um == 0 || !target.prepared.IsZero()) return {};
  const surface::Mesh mesh =
      surface::ExtractSurface(scene::Prepared(prepared.volume, *shape, scene::Neighbours::kSpared));
  return Whole(mesh, mesh.tissue);
}

Result<render::GroupMesh> DeviationSurface(const surface::Mesh& after, ByteView bytes) {
  ENAMEL_ASSIGN_OR_RETURN(const auto deviation, timeline::DecodeDeviation(bytes));
  const Cells cells(deviation);
  std::vector<uint8_t> materials;
  materials.reserve(after.position_m.size());
  for (const glm::vec3& position_m : after.position_m) {
    const auto off_mm = cells.At_mm(position_m);
    materials.push_back(off_mm ? render::DeviationMaterial(*off_mm) : render::kUntouched);
  }
  return Whole(after, materials);
}

ResultPictures::ResultPictures(const ResultSurfaces& surfaces)
    : painter_(surfaces.camera, kStill_px) {
  using Colours = render::StillPainter::Colours;
  before = painter_.Paint(surfaces.before, Colours::kTissues);
  after = painter_.Paint(surfaces.after, Colours::kTissues);
}

void ResultPictures::Add(const render::GroupMesh& wanted,
                         const std::optional<render::GroupMesh>& off) {
  using Colours = render::StillPainter::Colours;
  if (!wanted.indices.empty()) target = painter_.Paint(wanted, Colours::kTissues);
  if (off) deviation = painter_.Paint(*off, Colours::kDeviation);
}

}  // namespace enamel::station::desk
