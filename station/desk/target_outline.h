#pragma once

#include <future>
#include <vector>

#include "common/scoring/zones.h"
#include "common/surface/level_lines.h"

namespace enamel::station::desk {

// The target's outline on the tooth: where the surface before the first cut meets what has to go.
// Of whatever kind the target is. Neighbours bear no line. None where the target is not in the scene.
std::vector<surface::LineSegment> OutlineOf(const scene::Scene& scene,
                                            const scene::CavityTarget& target,
                                            const cutting::Volume& initial);

// The same on a thread of its own, as the whole surface is looked at.
// Thread safety: owner's thread. Destroying it waits for the end.
class TargetOutline {
 public:
  // All three outlive this.
  TargetOutline(const scene::Scene& scene, const scene::CavityTarget& target,
                const cutting::Volume& initial);

  // Once it is known: true, once, and `lines` is filled.
  bool Take(std::vector<surface::LineSegment>& lines);

 private:
  std::future<std::vector<surface::LineSegment>> coming_;
};

}  // namespace enamel::station::desk
