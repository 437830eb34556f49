#include "station/desk/result_pictures.h"

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "common/timeline/deviation.h"
#include "station/desk/desk_attempt.h"
#include "station/render/materials.h"

namespace enamel::station::desk {
namespace {

constexpr int kStill_px = 640;  // of a side

}  // namespace

Result<ResultSurfaces> SurfacesOf(LookBack& recording,
                                  const std::function<bool(double)>& keep_going) {
  ENAMEL_ASSIGN_OR_RETURN(auto end, recording.Take(UINT64_MAX, UINT64_MAX, keep_going));
  const PreparedAttempt& prepared = recording.prepared();
  ResultSurfaces out;
  out.camera = render::StillCamera(ViewOf(prepared), prepared.volume);
  const surface::Mesh before = surface::ExtractSurface(prepared.volume);
  render::Append(before, render::ToothLooks(prepared.volume), out.before);
  const cutting::Volume& after = end.core->volume();
  out.after_surface = surface::ExtractSurface(after, &out.after_cells);
  render::Append(out.after_surface, render::ToothLooks(after, &prepared.volume), out.after);
  return out;
}

render::GroupMesh TargetSurface(const PreparedAttempt& prepared) {
  const auto target = PreparedFor(prepared.scene, prepared.exercise.target, prepared.volume);
  if (!target) return {};
  render::GroupMesh out;
  render::Append(surface::ExtractSurface(*target), render::ToothLooks(*target, &prepared.volume),
                 out);
  return out;
}

Result<render::GroupMesh> DeviationSurface(const surface::Mesh& after, std::span<const ivec3> cells,
                                           ByteView bytes) {
  ENAMEL_ASSIGN_OR_RETURN(const auto deviation, timeline::DecodeDeviation(bytes));
  const timeline::DeviationByCell known(deviation);
  std::vector<uint8_t> materials;
  materials.reserve(cells.size());
  for (const ivec3& cell : cells) {
    const auto off_um = known.At_um(cell);
    materials.push_back(off_um ? render::DeviationMaterial(1e-3 * *off_um) : render::kUntouched);
  }
  render::GroupMesh out;
  render::Append(after, materials, out);
  return out;
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
