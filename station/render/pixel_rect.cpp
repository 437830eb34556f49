#include "station/render/pixel_rect.h"

#include <algorithm>
#include <cmath>

namespace enamel::station::render {
namespace {

// Pixels along one axis of [middle - radius, middle + radius] between two depths.
struct Extent {
  int from = 0, to = 0;
};

Extent Along(float middle, float radius, float near, float far, float slope, int pixels) {
  auto pixel = [&](float offset, float depth) {
    return (offset * slope / depth + 1) * 0.5f * static_cast<float>(pixels);
  };
  float lo = middle - radius, hi = middle + radius;
  // A border left of the middle is farthest left at its nearest point, one right of it at its
  // farthest.
  float from = pixel(lo, lo < 0 ? near : far), to = pixel(hi, hi > 0 ? near : far);
  auto limit = static_cast<float>(pixels);
  return {static_cast<int>(std::floor(std::clamp(from, 0.0f, limit))),
          static_cast<int>(std::ceil(std::clamp(to, 0.0f, limit)))};
}

}  // namespace

PixelRect PixelRect::Around(const PixelRect& o) const {
  if (empty()) return o;
  if (o.empty()) return *this;
  return {std::min(x0, o.x0), std::min(y0, o.y0), std::max(x1, o.x1), std::max(y1, o.y1)};
}

PixelRect PixelRect::Within(const PixelRect& o) const {
  PixelRect out{std::max(x0, o.x0), std::max(y0, o.y0), std::min(x1, o.x1), std::min(y1, o.y1)};
  return out.empty() ? PixelRect{} : out;
}

PixelRect PixelRect::Grown(int margin, int width, int height) const {
  if (empty()) return {};
  return {std::max(x0 - margin, 0), std::max(y0 - margin, 0), std::min(x1 + margin, width),
          std::min(y1 + margin, height)};
}

PixelRect AroundBall(const glm::mat4& view_from_scene, const glm::mat4& clip_from_view, int width,
                     int height, const glm::vec3& middle_mm, float radius_mm) {
  glm::vec3 p(view_from_scene * glm::vec4(middle_mm, 1));
  float near = -p.z - radius_mm, far = -p.z + radius_mm;
  if (near <= 1e-3f) return PixelRect::Whole(width, height);
  Extent x = Along(p.x, radius_mm, near, far, clip_from_view[0][0], width);
  Extent y = Along(p.y, radius_mm, near, far, clip_from_view[1][1], height);
  return {x.from, y.from, x.to, y.to};
}

}  // namespace enamel::station::render
