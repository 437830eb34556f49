#pragma once

#include <glm/mat4x4.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/cutting/bur.h"
#include "common/surface/level_lines.h"
#include "station/render/gl_objects.h"
#include "station/render/mesher.h"
#include "station/render/pixel_rect.h"
#include "station/render/quality.h"

namespace enamel::station::render {

// Contents of one frame; millimetres, scene frame.
struct PictureState {
  glm::mat4 view_from_scene{1}, clip_from_view{1};
  std::optional<glm::mat4> scene_from_bur;    // none: not drawn
  std::optional<glm::mat4> scene_from_ghost;  // only with scene_from_bur
  glm::vec3 arrow_from_mm{0}, arrow_mm{0};    // zero: no arrow
  float bur_spin = 0;                         // rad
  bool lines = false;                         // draw SetLines' lines
};

// Statistics of the last Draw.
struct PictureWork {
  size_t triangles = 0;        // of the tooth, all of it
  size_t triangles_drawn = 0;  // of the tooth, this time
  bool whole = false;          // the tooth was redrawn everywhere
  bool coarse = false;         // with coarse triangles, because the camera moves
};

// The solid part of the picture, by OpenGL 3.3. The tooth is kept as a layer: colour, depth and
// ambient occlusion. It is redrawn only where a mesh has changed, or everywhere when the camera has
// moved. Each frame draws the moving things over a copy of that layer: the bur's shadow, the bur,
// the ghost of the hand, the force. *Why:* while somebody cuts, the camera rests and the cut
// changes a thousandth of the surface; a computer without graphics card cannot redraw all of it
// each time. While the camera moves the layer may be a lighter one (Quality::lighter_turning); it
// is redrawn in full once the camera has rested for kStillPictures. Draws into its own buffer; the
// panel is then drawn over that. Needs the context current. Not thread-safe.
class Picture {
 public:
  static constexpr int kStillPictures = 4;

  // Throws std::runtime_error when the driver refuses a resource.
  Picture(const cutting::Bur& bur, size_t group_count);

  void Replace(const GroupMesh& mesh);
  // Lines on the tooth, in front of it by half their width.
  void SetLines(std::span<const surface::LineSegment> lines);
  void Draw(const PictureState& state, int width, int height, const Quality& wanted);
  // Valid after Draw.
  const Target& result() const { return *result_; }
  const PictureWork& work() const { return work_; }

 private:
  struct Group {
    TriangleBuffer triangles;
    Bounds bounds;
  };

  // The quality to draw with now, depending on whether the camera moved.
  Quality QualityNow(const PictureState& state, const Quality& wanted);
  bool MayBeSeen(const Bounds& bounds, const PictureState& state) const;
  void Resize(int width, int height, const Quality& quality);
  // The parts of the layer to redraw: the change itself, and its surroundings whose light changes.
  struct Stale {
    PixelRect solids, around;
  };
  Stale StalePart(const PictureState& state, const Quality& quality);
  void UseSolid(const PictureState& state);
  void UseTooth(const PictureState& state);
  void DrawBackground();
  void DrawTooth(const PictureState& state, const PixelRect& part);
  void DrawOcclusion(const PictureState& state, const Quality& quality, const PixelRect& part);
  void Compose(const PictureState& state, const Quality& quality, const PixelRect& part);
  void CopyTooth();
  void DrawLines(const PictureState& state);
  void DrawShadow(const PictureState& state);
  void DrawBurs(const PictureState& state);
  void DrawBur(const PictureState& state, const glm::mat4& scene_from_bur, int parts);
  void DrawArrow(const PictureState& state);

  Program kept_, solid_, occlusion_, blur_, compose_, background_, shadow_;
  std::vector<std::unique_ptr<Group>> groups_;
  TriangleBuffer bur_head_, bur_shank_, shaft_, tip_, lines_;
  float bur_height_mm_, bur_radius_mm_;
  GLuint empty_array_ = 0;
  PictureWork work_;
  // The tooth's layer: as drawn, its occlusion, and both composed over the background; and its
  // inputs.
  std::unique_ptr<Target> solids_, occluded_, blurred_, composed_, empty_;
  PixelRect tooth_;  // the part of the picture it covers
  glm::mat4 drawn_view_{0}, drawn_clip_{0};
  Quality drawn_quality_;
  std::optional<glm::mat4> last_view_;
  int still_ = kStillPictures;   // pictures since the camera moved
  std::vector<Bounds> changed_;  // since then: the old and new surface
  // The frame, at the layer's size and at the window's.
  std::unique_ptr<Target> frame_, result_;
};

}  // namespace enamel::station::render
