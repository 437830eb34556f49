#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

namespace enamel::station {

struct FrameBenchOptions {
  int width_px = 1280, height_px = 720;
  int frames = 120;  // of each kind
  int voxel_um = 50;
  std::string quality;  // empty: as it begins on this computer
  std::filesystem::path json;
};

// Draws the built-in molar with panel, as an attempt does, and prints how long frames take here: at
// rest (the bur moves in the air), while cutting, and while the camera turns, lighter as it does in
// an attempt and in full. Each frame is drawn
// to its end (glFinish) and not held back for the display. Errors: kUnavailable without a display
// or OpenGL 3.3; kInvalidInput for an unknown quality.
Status BenchFrames(const FrameBenchOptions& options);

}  // namespace enamel::station
