#include "station/lab/pictures/picture_change.h"

#include <algorithm>
#include <cmath>

#include "station/lab/pictures/flip.h"

namespace enamel::station::lab {
namespace {

// A kept picture shows what fills a window 1080 pixels high. There FLIP's own viewer, 0.7 m before a
// screen 0.7 m and 3840 pixels wide, has 67 pixels a degree.
constexpr double kPixelsPerDegree = 67.02 * 216 / 1080;
constexpr int kDegree_px = 13;

void Paint(float error, uint8_t* rgb) {
  // Brighter than the error, whose noticeable values are low.
  const double bright = 3 * std::sqrt(static_cast<double>(error));
  for (int c = 0; c < 3; ++c) {
    rgb[c] = static_cast<uint8_t>(std::lround(255 * std::clamp(bright - c, 0.0, 1.0)));
  }
}

}  // namespace

std::optional<PictureChange> ChangeBetween(const render::Image& kept, const render::Image& now) {
  if (kept.width != now.width || kept.height != now.height) return std::nullopt;
  const std::vector<float> error = Flip(kept, now, kPixelsPerDegree);
  const WorstPlace worst = WorstOf(error, now.width, kDegree_px);
  PictureChange out;
  out.worst = worst.mean;
  out.x = worst.x, out.y = now.height - 1 - worst.y;
  out.map = render::Image(now.width, now.height);
  for (size_t i = 0; i < error.size(); ++i) {
    out.mean += static_cast<double>(error[i]) / static_cast<double>(error.size());
    Paint(error[i], &out.map.rgb[3 * i]);
  }
  return out;
}

}  // namespace enamel::station::lab
