#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace enamel::station::render {

// Pixels [x0, x1) x [y0, y1) of a picture, first row at the bottom.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  static PixelRect Whole(int width, int height) { return {0, 0, width, height}; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  bool Meets(const PixelRect& o) const { return x0 < o.x1 && o.x0 < x1 && y0 < o.y1 && o.y0 < y1; }
  // The intersection.
  PixelRect Within(const PixelRect& o) const;
  // Smallest rectangle around both; an empty one adds nothing.
  PixelRect Around(const PixelRect& o) const;
  // With `margin` pixels more on every side, inside a picture of this size.
  PixelRect Grown(int margin, int width, int height) const;
  bool operator==(const PixelRect&) const = default;
};

// A rectangle with every pixel of a ball, slightly larger, never smaller. The whole picture if the
// ball reaches the eye. `clip_from_view` is a symmetric perspective.
PixelRect AroundBall(const glm::mat4& view_from_scene, const glm::mat4& clip_from_view, int width,
                     int height, const glm::vec3& middle_mm, float radius_mm);

}  // namespace enamel::station::render
