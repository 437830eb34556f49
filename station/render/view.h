#pragma once

#include <vector>

#include "common/cutting/bur.h"
#include "common/math/vec.h"

namespace enamel::station::render {

enum class View { kOblique, kOcclusal, kBuccal, kMesial };

// Parameters of an attempt's picture, set before the first tick.
struct ViewOptions {
  // Those that the handpiece can have; FrameState::bur says which. At least one.
  std::vector<cutting::Bur> burs = std::vector<cutting::Bur>(1);
  double force_full_scale_n = 3.0;  // full length of the arrow and the bar
  View view = View::kOblique;
  // The point the camera orbits, scene frame; the middle of the crown for a tooth.
  dvec3 focus_m{0};
  // Radius (m) that should fill the view; 0: from the volume's surface.
  double view_radius_m = 0;
  // Its distance right of the picture's middle, in picture heights: a panel is on the left.
  float aside = 0;
  // The place to cut and how far around it to look, for StillCamera; radius 0: the whole view.
  dvec3 work_m{0};
  double work_radius_m = 0;
  // The crown is toward -y: a face of the tooth is up, not its occlusal side.
  bool crown_aside = false;
  int mesial_x = 1;       // scene::MesialX, for the view from there
  bool handpiece = true;  // around the bur
};

}  // namespace enamel::station::render
