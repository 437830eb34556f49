#include "station/desk/target_outline.h"

#include <chrono>

#include "common/scene/preparation.h"
#include "common/scene/prepared_target.h"
#include "station/mouth/mouth.h"

namespace enamel::station::desk {

std::vector<surface::LineSegment> OutlineOf(const scene::Scene& scene,
                                            const scene::CavityTarget& target,
                                            const cutting::Volume& initial) {
  const auto shape = scene::TargetShape(scene, target);
  const bool prepared = !target.prepared.IsZero();
  if (!shape.ok() || target.depth_um == 0 || (prepared && !target.prepared_tooth)) return {};
  const surface::Mesh mesh = surface::ExtractSurface(initial);
  std::vector<float> beyond_mm(mesh.position_m.size(), 1);
  for (size_t i = 0; i < beyond_mm.size(); ++i) {
    if (mesh.tissue[i] == static_cast<uint8_t>(cutting::Tissue::kNeighbour)) continue;
    const dvec3 p(mesh.position_m[i]);
    // Where the surface stays, a prepared tooth's is only as near as the voxels show.
    const double beyond_m =
        prepared ? 0.5 * initial.spec().voxel_m() - target.prepared_tooth->volume.DistanceAt_m(p)
                 : scene::PreparationDistance_m(*shape, p);
    beyond_mm[i] = static_cast<float>(1e3 * beyond_m);
  }
  return surface::ZeroLines(mesh, beyond_mm);
}

std::optional<cutting::Volume> PreparedFor(const scene::Scene& scene,
                                           const scene::CavityTarget& target,
                                           const cutting::Volume& initial) {
  if (target.prepared_tooth) return target.prepared_tooth->volume;
  const auto shape = scene::TargetShape(scene, target);
  if (!shape.ok() || target.depth_um == 0 || !target.prepared.IsZero()) return std::nullopt;
  return scene::Prepared(initial, *shape, scene::Neighbours::kSpared);
}

Surroundings::Surroundings(const scene::Scene& scene, const scene::Exercise& exercise,
                           const cutting::Volume& initial, bool mouth)
    : coming_(std::async(std::launch::async, [&scene, &exercise, &initial, mouth] {
        Found found{OutlineOf(scene, exercise.target, initial), {}};
        if (mouth) {
          found.mouth = mouth::MakeMouth(scene, initial, found.outline, {exercise.isolation});
        }
        return found;
      })) {}

bool Surroundings::done() const {
  return !coming_.valid() || coming_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

std::optional<Surroundings::Found> Surroundings::Take() {
  if (!coming_.valid() || !done()) return std::nullopt;
  return coming_.get();
}

}  // namespace enamel::station::desk
