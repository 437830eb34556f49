#pragma once

#include <optional>
#include <string>

#include "common/cutting/volume.h"
#include "common/language/words.h"
#include "common/scene/types.h"
#include "station/render/camera.h"
#include "station/render/fonts.h"

namespace enamel::station::desk {

// How deep a point is under the surface that the tooth had before the first cut. Of a cavity, along
// z, as instructions and score give its depth. Of a crown, whose sides are cut as well, the least
// along z, level, and half-way between, to each side: exact where the surface faces such a
// direction, and at most 8 % too much elsewhere (the directions are up to 22.5 degrees away,
// 1 / cos 22.5 deg = 1.08). Thread safety: const.
class DepthGauge {
 public:
  // `initial` outlives this.
  DepthGauge(const scene::CavityTarget& target, const cutting::Volume& initial);

  // Metres, known to a few hundredths of a voxel where the surface is smooth. None: the point is not
  // under that surface.
  std::optional<double> Depth_m(const dvec3& point_m) const;
  // "1.35 mm": in steps of a voxel, which is what a cut's surface is known to.
  std::string Text(const language::Words& words, double depth_m) const;

 private:
  // To the surface along a unit vector; as much as the grid has, where that has none.
  double Along_m(dvec3 at_m, const dvec3& direction) const;

  const bool sides_;
  const cutting::Volume& initial_;
};

// Writes beside a point of the scene, in the current ImGui frame of a picture of this size: a
// figure, and below it a warning. Either may be empty. Nothing where the picture does not have the
// point.
void WriteBeside(const dvec3& point_m, const std::string& figure, const std::string& warning,
                 const render::Camera& camera, const render::Fonts& fonts, int width, int height);

}  // namespace enamel::station::desk
