#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/cutting/profile.h"
#include "common/cutting/volume.h"
#include "common/language/words.h"
#include "common/scene/types.h"
#include "station/render/camera.h"
#include "station/render/fonts.h"

namespace enamel::station::desk {

// Where the bur's end is in a tooth, metres.
struct BurDepth {
  // The depth of the bur's deepest point. None: that point is above where depths are measured from.
  std::optional<double> deep_m;
  // How far the bur may still be lowered straight down before its end meets the target's floor;
  // negative below the floor. None: the target has no floor there.
  std::optional<double> to_floor_m;
};

// How deep the bur's end is, and how far it is above the floor that the exercise asks for.
//
// The score takes a level floor's depth from the target's landmark, such as the central fossa. The
// gauge does the same: the uncut surface beside the fossa is higher, by 0.3 mm on average over a
// class I cavity of the built-in molar. The two figures then add up to the depth of the target.
//
// A crown, a veneer and a prepared tooth follow the tooth's surface. Their depth is measured from the
// surface before the first cut: along z for a prepared tooth; for crown and veneer the least along
// z, level, and half-way between, to each side. The least is exact where the surface faces such a
// direction, and at most 8 % too much elsewhere: directions are up to 22.5 degrees away, and 1 / cos
// 22.5 deg = 1.08.
//
// The floor is the part of the target's end that faces up within 60 degrees. The figure is exact
// for level floors, and for the others known to the spacing of points on the bur's end: 0.02 mm on a
// slope of 45 degrees. Thread safety: const.
class DepthGauge {
 public:
  // `initial` outlives this, as does target.prepared_tooth.
  DepthGauge(const scene::Scene& scene, const scene::CavityTarget& target,
             const std::vector<cutting::Bur>& burs, const cutting::Volume& initial);

  // Nothing where the bur's deepest point is not under the uncut surface.
  // Requires: bur is one of the burs' numbers.
  BurDepth At(const cutting::Pose& pose, size_t bur = 0) const;
  // "1.35 mm deep", and on a second line "0.65 mm to the floor": in steps of a voxel, which is what
  // a cut's surface is known to.
  std::string Text(const language::Words& words, const BurDepth& depth) const;

 private:
  struct End {
    cutting::Profile profile;
    std::vector<cutting::SurfacePoint> points;  // none: the floor is level
  };
  // Under the surface that the tooth had.
  double UnderSurface_m(const dvec3& point_m) const;
  double Along_m(dvec3 at_m, const dvec3& direction) const;
  // Negative in what has to go.
  double BeyondTarget_m(const dvec3& point_m) const;
  bool FacesUp(const dvec3& point_m) const;
  std::optional<double> Fall_m(const dvec3& point_m) const;
  std::optional<double> ToFloor_m(const cutting::Pose& pose, const End& end,
                                  const dvec3& deepest_m) const;
  double Rounded_mm(double metres) const;

  bool sides_ = false;
  std::optional<double> from_z_m_;  // a level floor's: depths begin there
  std::optional<scene::Preparation> shape_;
  std::shared_ptr<const scene::PreparedTooth> prepared_;
  double errs_ = 1;  // of BeyondTarget_m (preparation.h)
  std::vector<End> ends_;
  const cutting::Volume& initial_;
};

// Writes beside a point of the scene, in the current ImGui frame of a picture of this size: a
// figure, and below it a warning. Either may be empty or have several lines. Nothing where the
// picture does not have the point.
void WriteBeside(const dvec3& point_m, const std::string& figure, const std::string& warning,
                 const render::Camera& camera, const render::Fonts& fonts, int width, int height);

}  // namespace enamel::station::desk
