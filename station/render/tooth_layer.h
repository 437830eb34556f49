#pragma once

#include <glm/mat4x4.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "station/render/gl_objects.h"
#include "station/render/mesher.h"
#include "station/render/pixel_rect.h"
#include "station/render/quality.h"

namespace enamel::station::render {

// Reach of ambient occlusion: about half a cavity's width.
inline constexpr float kOcclusionRadius_mm = 1.6f;

// Where a picture is seen from; millimetres, scene frame.
struct Eye {
  glm::mat4 view_from_scene{1}, clip_from_view{1};
  // The view is a mirror image: triangles wind the other way, and only what is before the mirror is
  // seen, where dot(before, (p, 1)) >= 0 in the view's frame.
  bool mirrored = false;
  glm::vec4 before{0, 0, 0, 1};

  bool operator==(const Eye&) const = default;
  glm::vec3 up_in_view() const { return glm::vec3(view_from_scene[2]); }
};

// A part of what does not move, with its bounds.
struct Body {
  TriangleBuffer triangles;
  Bounds bounds;
};

// The tooth as one eye sees it: colour, depth and ambient occlusion, composed over the background.
// Kept from picture to picture: it is redrawn only where a mesh has changed, or everywhere when the
// eye has moved. Needs the context current. Not thread-safe.
class ToothLayer {
 public:
  // The programs, which layers share.
  struct Programs {
    Programs();
    Program kept, occlusion, blur, compose, background;
    GLuint empty_array = 0;
  };
  // Statistics of the last Draw.
  struct Work {
    size_t triangles_drawn = 0;
    bool whole = false;  // everything was redrawn
  };

  explicit ToothLayer(const Programs& programs) : programs_(programs) {}

  // A picture of this size: true if it has another size now. Everything is then redrawn.
  bool Resize(int width, int height);
  // The surface here has changed; asked before and after the change.
  void Changed(const Bounds& bounds) {
    if (drawn_eye_) changed_.push_back(bounds);
  }
  // What is drawn will not be used again.
  void Forget() {
    drawn_eye_.reset();
    changed_.clear();
  }
  // Draws `bodies` into the part `wanted` of the picture; the rest may be old.
  void Draw(std::span<const Body* const> bodies, const Eye& eye, const Quality& quality,
            const PixelRect& wanted);
  // Valid after Draw.
  const Target& solids() const { return *solids_; }
  const Target& composed() const { return *composed_; }
  const Work& work() const { return work_; }
  int width() const { return solids_ ? solids_->width() : 0; }
  int height() const { return solids_ ? solids_->height() : 0; }

 private:
  // The parts to redraw: the change itself, and its surroundings whose light changes.
  struct Stale {
    PixelRect solids, around;
  };
  Stale StalePart(const Eye& eye, const Quality& quality, const PixelRect& wanted);
  void DrawBackground();
  void DrawTooth(std::span<const Body* const> bodies, const Eye& eye, bool coarse,
                 const PixelRect& part);
  void DrawOcclusion(const Eye& eye, const Quality& quality, const PixelRect& part);
  void Compose(const Eye& eye, const Quality& quality, const PixelRect& part);

  const Programs& programs_;
  Work work_;
  // As drawn, its occlusion, and both composed over the background; and their inputs.
  std::unique_ptr<Target> solids_, occluded_, blurred_, composed_, empty_;
  PixelRect tooth_;  // the part of the picture it covers
  std::optional<Eye> drawn_eye_;
  Quality drawn_quality_;
  PixelRect drawn_part_;
  std::vector<Bounds> changed_;  // since then: the old and new surface
};

// Drawing is limited to these pixels.
void Scissor(const PixelRect& part);
// For triangles of a body: culled, and cut off at the mirror, as the eye asks.
void SeeWith(const Eye& eye);

}  // namespace enamel::station::render
