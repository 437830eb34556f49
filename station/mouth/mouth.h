#pragma once

#include <span>

#include "common/cutting/volume.h"
#include "common/scene/types.h"
#include "common/surface/level_lines.h"
#include "station/render/scenery.h"

namespace enamel::station::mouth {

struct MouthOptions {
  scene::Isolation isolation = scene::Isolation::kNone;
  bool antagonist = true;
};

// What of the mouth is drawn around a tooth: gingiva at its neck and at its neighbours', or a rubber
// dam in the gingiva's place; where the scene has no neighbours of its own, crowns beside it in the
// shape of built-in teeth; and the opposite teeth. Nothing of it is in the volume: the bur passes
// through it, no force and no score knows it.
//
// Empty where the scene has no tooth number, or the tooth shows no cement line. `outline`: where the
// surface meets what is to be cut; gingiva and dam keep clear of it. Not real-time; some 0.2 s.
render::Scenery MakeMouth(const scene::Scene& scene, const cutting::Volume& initial,
                          std::span<const surface::LineSegment> outline,
                          const MouthOptions& options = {});

}  // namespace enamel::station::mouth
