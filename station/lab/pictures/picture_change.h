#pragma once

#include <optional>

#include "station/render/png_file.h"

namespace enamel::station::lab {

// A change of this size, PictureChange::worst, is noticed. Another version of the driver makes 0.022 at
// most (measured); enamel as much yellower as half of all people see makes 0.060, a seam a pixel wide
// and a tenth darker 0.047 (picture_change_test).
inline constexpr double kNoticed = 0.035;

// How a picture differs from the kept one.
struct PictureChange {
  double worst = 0;   // mean FLIP of the worst square, one degree of the viewer's field
  int x = 0, y = 0;   // its middle, from the top left
  double mean = 0;    // FLIP of the whole picture
  render::Image map;  // of FLIP: black where the same, over red and yellow to white

  bool seen() const { return worst >= kNoticed; }
};

// None where their sizes differ.
std::optional<PictureChange> ChangeBetween(const render::Image& kept, const render::Image& now);

}  // namespace enamel::station::lab
