#pragma once

#include <array>

#include "common/cutting/volume.h"
#include "common/surface/surface.h"

// The task is what the reference took away. It divides an attempt's removal into done, missed and
// beyond, near the reference's cut and far from it. Deterministic. Thread safety: functions, any
// thread.
namespace enamel::scoring {

using TissueVolumes_m3 = std::array<double, cutting::kTissueCount>;  // by cutting::Tissue
double Sum_m3(const TissueVolumes_m3& volumes);

struct TaskVolumes {
  TissueVolumes_m3 task{};    // what the reference took
  TissueVolumes_m3 missed{};  // of it, what the attempt left
  // The part of it that is farther than kStanding_m from the reference's cut: a pillar, a septum, a
  // lid; not a wall or floor that is short.
  TissueVolumes_m3 standing{};
  TissueVolumes_m3 near{};     // what the attempt took beyond it, within `near_m` of its cut
  TissueVolumes_m3 outside{};  // and farther away

  static constexpr double kStanding_m = 0.4e-3;

  double task_m3() const { return Sum_m3(task); }
  double done_m3() const { return task_m3() - Sum_m3(missed); }
};

// IsCut (deviation.h) at each vertex of `mesh`, the surface of `after`.
std::vector<bool> CutVertices(const surface::Mesh& mesh, const cutting::Volume& initial,
                              const cutting::Volume& after);

// The triangles of `mesh` with a vertex that is marked.
surface::Mesh CutPart(const surface::Mesh& mesh, const std::vector<bool>& cut);

// Voxel by voxel, with f = SolidFraction: the reference took f0 - fr, the attempt f0 - fa; of
// voxels in which both took some, the smaller is done. `reference_cut` is the reference's cut
// surface (CutPart). Without one (a reference that cut nothing) all that went is outside.
// Requires: equal grids; near_m >= 0.
TaskVolumes MeasureTask(const cutting::Volume& initial, const cutting::Volume& attempt,
                        const cutting::Volume& reference,
                        const surface::DistanceQuery& reference_cut, double near_m);

}  // namespace enamel::scoring
