#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "common/cutting/profile.h"
#include "common/cutting/volume.h"
#include "common/language/words.h"
#include "station/render/panel.h"
#include "station/sound/warning_tone.h"

namespace enamel::station::desk {

// Nearer than this, the window warns. Pulp: the thickness that is too thin (kPulpThin_mm).
inline constexpr double kWarnPulp_m = render::kPulpThin_mm * 1e-3;
// A box that breaks the contact as it should leaves half a millimetre, so that the tip of an
// explorer passes: nearer than 0.3 mm no correct box needs the bur.
inline constexpr double kWarnNeighbour_m = 0.3e-3;

struct Warned {
  sound::Hazard about = sound::Hazard::kPulp;
  double nearness = 0;  // 0: not near; 1: touching
};

// The warning for those who do not hear its tone: "Pulp: 0.3 mm away". Empty: nothing is near.
std::string NearText(const language::Words& words, const Warned& warned);

// How near the bur's cutting part comes to the pulp and to adjacent teeth, as they were before the
// first cut. Known to half a voxel, in the direction of a warning: a pulp's surface runs between
// its voxels and the others.
//
// Thread safety: Look by one thread (the mesher's); Near by one thread, from any time on.
class NearnessWatch {
 public:
  // `initial` outlives this.
  NearnessWatch(const std::vector<cutting::Bur>& burs, const cutting::Volume& initial);

  // Finds the surfaces, once.
  void Look();
  // The hazard that is nearest for its own distance. Nothing before Look.
  // Requires: bur is one of the burs' numbers.
  Warned Near(const cutting::Pose& pose, size_t bur = 0) const;

 private:
  struct Point {
    dvec3 at_m;
    double inside_m;  // behind the surface
  };
  // Points of one brick, in a ball.
  struct Cluster {
    sound::Hazard hazard;
    dvec3 middle_m;
    double radius_m;
    size_t first, end;
  };
  void AddBrick(int brick);

  struct Body {
    cutting::Profile profile;
    double reach_m;  // of the bur's cutting part, from its middle
    dvec3 middle_in_bur_m;
  };
  std::vector<Body> burs_;
  const cutting::Volume& initial_;
  std::vector<Point> points_;
  std::vector<Cluster> clusters_;
  std::atomic<bool> found_{false};  // from then on nothing above changes
};

}  // namespace enamel::station::desk
