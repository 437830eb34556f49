#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "common/base/mutex.h"
#include "common/scoring/hollow.h"
#include "common/scoring/zones.h"
#include "common/surface/surface.h"
#include "station/render/panel.h"

namespace enamel::station::desk {

// Watches how near the cut comes to what must stay: the pulp, and the end of the leeway beside and
// below the target. Distances are from where the original solid now ends: a point on each grid edge
// between a removed and a remaining voxel, interpolated linearly, so exact for walls along the
// grid. The pulp's surface runs between its voxels and the others, so it is known to half a voxel.
// A cut only comes nearer, so what is too far to matter is not checked again.
//
// Thread safety: Look by one thread (the mesher's), reach from any.
class ReachWatch {
 public:
  // `initial` outlives this. A scene without a target has no leeway, a scene without pulp no
  // distance to it.
  ReachWatch(const scene::Scene& scene, const scene::CavityTarget& target,
             const cutting::Volume& initial);
  ~ReachWatch();

  void Look(const cutting::Volume& now);
  // The reach, with the leeway of the side that has used the largest share of its own.
  render::Reach reach() const;

 private:
  // A direction in which a cut may go beyond the target, and how far it went.
  struct Side {
    const char* name;
    dvec3 outward;
    double at_m;      // of the target's face, along `outward`
    double leeway_m;  // may go beyond it
    double beyond_m;  // farthest so far
  };

  void LookAtBrick(const cutting::Volume& now, int brick);
  bool MayGoFarther(const dvec3& middle_m) const;
  bool MayBeNearerPulp(int brick, const dvec3& middle_m);
  void Publish();

  const cutting::Volume& initial_;
  // Owned by the looking thread.
  std::vector<Side> sides_;
  // For a target with parts or a prepared tooth, instead of sides: the farthest distance beyond its
  // outline or floor.
  bool FollowsShape() const { return shape_ || prepared_; }
  double BeyondShape_m(const dvec3& p_m) const;
  void LookBeyondShape(const dvec3& p_m);
  std::optional<scene::Preparation> shape_;
  std::shared_ptr<const scene::PreparedTooth> prepared_;
  std::unique_ptr<scoring::Hollow> hollow_;  // of prepared_, made with the first look
  double shape_leeway_m_ = 0, beyond_shape_m_ = 0;
  bool below_shape_ = false;                      // the farthest place is below the floor
  std::unique_ptr<surface::DistanceQuery> pulp_;  // null: there is none
  bool pulp_looked_for_ = false;
  std::vector<float> pulp_bound_m_;  // a brick's least distance to the pulp; negative: unknown
  double pulp_m_;
  mutable Mutex mutex_;
  render::Reach reach_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::station::desk
