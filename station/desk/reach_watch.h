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

// How near the cut has come to what must stay, while it is being made: to the pulp, and to the end
// of the leeway beside and below the target. Both from where solid that was there at the beginning
// now ends: a point on each grid edge from a voxel that went to one that stayed, linear in the
// distances, so exact for walls along the grid. The pulp's own surface is drawn between its voxels
// and the others, so it is known to half a voxel. A cut comes only nearer, so what is too far to
// matter is not looked at again.
//
// Thread safety: Look by one thread (the mesher's), reach from any.
class ReachWatch {
 public:
  // `initial` outlives this. Without a target in the scene there is no leeway to tell of, without
  // pulp none of that.
  ReachWatch(const scene::Scene& scene, const scene::CavityTarget& target,
             const cutting::Volume& initial);
  ~ReachWatch();

  void Look(const cutting::Volume& now);
  // Of the leeway: the side where most of it is gone, by share.
  render::Reach reach() const;

 private:
  // The way a cut may go beyond the target, and how far it went.
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
  // The looking thread's.
  std::vector<Side> sides_;
  // Of a target that has parts or is a prepared tooth, instead of sides: the farthest beyond its
  // outline or floor.
  bool FollowsShape() const { return shape_ || prepared_; }
  double BeyondShape_m(const dvec3& p_m) const;
  std::optional<scene::Preparation> shape_;
  std::shared_ptr<const scene::PreparedTooth> prepared_;
  std::unique_ptr<scoring::Hollow> hollow_;  // of prepared_, made with the first look
  double shape_leeway_m_ = 0, beyond_shape_m_ = 0;
  std::unique_ptr<surface::DistanceQuery> pulp_;  // null: there is none
  bool pulp_looked_for_ = false;
  std::vector<float> pulp_bound_m_;  // least a brick can be from the pulp; negative: not asked yet
  double pulp_m_;
  mutable Mutex mutex_;
  render::Reach reach_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::station::desk
