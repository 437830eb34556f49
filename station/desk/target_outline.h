#pragma once

#include <future>
#include <optional>
#include <vector>

#include "common/scoring/zones.h"
#include "common/surface/level_lines.h"
#include "station/render/scenery.h"

namespace enamel::station::desk {

// The target's outline on the tooth: where the surface before the first cut meets the material to
// be removed. Works for every kind of target. Neighbours have no line. Empty if the target is not
// in the scene.
std::vector<surface::LineSegment> OutlineOf(const scene::Scene& scene,
                                            const scene::CavityTarget& target,
                                            const cutting::Volume& initial);

// The tooth as a bur would leave it that can reach every corner; none where the target is none.
std::optional<cutting::Volume> PreparedFor(const scene::Scene& scene,
                                           const scene::CavityTarget& target,
                                           const cutting::Volume& initial);

// What the picture shows beside the tooth: the target's outline, and the mouth, whose gingiva keeps
// clear of it. Computed on a thread of its own, because both take the whole surface. Thread safety:
// owner's thread. The destructor waits for the end.
class Surroundings {
 public:
  struct Found {
    std::vector<surface::LineSegment> outline;
    render::Scenery mouth;
  };
  // All three outlive this. Without `mouth` there is none.
  Surroundings(const scene::Scene& scene, const scene::Exercise& exercise,
               const cutting::Volume& initial, bool mouth);

  bool done() const;
  // Once, when it is done.
  std::optional<Found> Take();

 private:
  std::future<Found> coming_;
};

}  // namespace enamel::station::desk
