#pragma once

#include <future>
#include <vector>

#include "common/scoring/zones.h"
#include "common/surface/level_lines.h"

namespace enamel::station::desk {

// The target's outline on the tooth: where the surface before the first cut meets the material to
// be removed. Works for every kind of target. Neighbours have no line. Empty if the target is not
// in the scene.
std::vector<surface::LineSegment> OutlineOf(const scene::Scene& scene,
                                            const scene::CavityTarget& target,
                                            const cutting::Volume& initial);

// Computes the outline on its own thread, because it takes the whole surface. Thread safety:
// owner's thread. The destructor waits for the end.
class TargetOutline {
 public:
  // All three outlive this.
  TargetOutline(const scene::Scene& scene, const scene::CavityTarget& target,
                const cutting::Volume& initial);

  // True once, when it is known and `lines` is filled.
  bool Take(std::vector<surface::LineSegment>& lines);

 private:
  std::future<std::vector<surface::LineSegment>> coming_;
};

}  // namespace enamel::station::desk
