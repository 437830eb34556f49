#pragma once

#include <glm/mat4x4.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/cutting/bur.h"
#include "common/surface/level_lines.h"
#include "station/render/chips.h"
#include "station/render/gl_objects.h"
#include "station/render/mesher.h"
#include "station/render/quality.h"
#include "station/render/scenery.h"
#include "station/render/tooth_layer.h"

namespace enamel::station::render {

// Contents of one frame; millimetres, scene frame.
struct PictureState {
  glm::mat4 view_from_scene{1}, clip_from_view{1};
  std::optional<glm::mat4> scene_from_bur;     // none: not drawn
  std::optional<glm::mat4> scene_from_ghost;   // only with scene_from_bur
  glm::vec3 arrow_from_mm{0}, arrow_mm{0};     // zero: no arrow
  float bur_spin = 0;                          // rad
  size_t bur = 0;                              // of the picture's burs
  std::optional<float> handle_azimuth;         // handpiece.h; none: a bur without its handpiece
  bool lines = false;                          // draw SetLines' lines
  bool scenery = false;                        // draw SetScenery's
  std::span<const Chip> chips;                 // only with scene_from_bur
  std::optional<glm::mat4> scene_from_mirror;  // none: no mirror (mouth_mirror.h)
};

// Statistics of the last Draw.
struct PictureWork {
  size_t triangles = 0;        // of the tooth, all of it
  size_t triangles_drawn = 0;  // of the tooth, this time
  bool whole = false;          // the tooth was redrawn everywhere
  bool coarse = false;         // with coarse triangles, because the camera moves
};

// The solid part of the picture, by OpenGL 3.3. The tooth is kept as a layer (tooth_layer.h). Each
// frame draws the moving things over a copy of that layer: the bur's shadow, chips, the bur in its
// handpiece, the ghost of the hand, the mirror, the force. *Why:* while somebody cuts, the camera rests and the cut
// changes a thousandth of the surface; a computer without graphics card cannot redraw all of it.
// While the camera moves the layer may be a lighter one (Quality::lighter_turning); it is redrawn in
// full once the camera has rested for kStillPictures. The mirror has a layer of its own, seen by the
// mirrored eye, only while it is shown and only where its glass is. Draws into its own buffer; the
// panel is then drawn over that. Needs the context current. Not thread-safe.
class Picture {
 public:
  static constexpr int kStillPictures = 4;

  // Throws std::runtime_error when the driver refuses a resource.
  Picture(std::span<const cutting::Bur> burs, size_t group_count);

  void Replace(const GroupMesh& mesh);
  // Lines on the tooth, in front of it by half their width.
  void SetLines(std::span<const surface::LineSegment> lines);
  // What stands around the tooth, in its layer.
  void SetScenery(const Scenery& scenery);
  void Draw(const PictureState& state, int width, int height, const Quality& wanted);
  // Valid after Draw.
  const Target& result() const { return *result_; }
  const PictureWork& work() const { return work_; }

 private:
  struct BurBody {
    TriangleBuffer head, shank, handpiece;
    float height_mm = 0, radius_mm = 0;
  };
  // What one eye sees: the tooth, and the frame with the moving things over it.
  struct Sight {
    explicit Sight(const ToothLayer::Programs& programs) : tooth(programs) {}
    void Resize(int width, int height);
    ToothLayer tooth;
    std::unique_ptr<Target> frame;
  };

  // The quality to draw with now, depending on whether the camera moved.
  Quality QualityNow(const PictureState& state, const Quality& wanted);
  void Changed(const Bounds& bounds);
  // What to draw into the layer for this state.
  void ChooseBodies(const PictureState& state);
  // Tooth, lines, shadow into the part of the frame; then chips and burs, which may be before it.
  void DrawSight(Sight& sight, const PictureState& state, const Eye& eye, const Quality& quality,
                 const PixelRect& part);
  void DrawMirror(const Sight& sight, const PictureState& state, const Eye& eye,
                  const Quality& quality);
  void UseSolid(const PictureState& state, const Eye& eye);
  void DrawShadow(const Sight& sight, const PictureState& state, const Eye& eye,
                  const PixelRect& part);
  void DrawBurs(const PictureState& state, const Eye& eye);
  // After all that may be behind it: as glass where it would hide the bur's tip.
  void DrawHandpiece(const PictureState& state, const Eye& eye);
  void DrawBur(const BurBody& bur, const Eye& eye, const glm::mat4& scene_from_bur, int parts);
  void DrawArrow(const PictureState& state, const Eye& eye);

  const ToothLayer::Programs programs_;
  Program solid_, shadow_, mirror_;
  std::vector<std::unique_ptr<Body>> groups_;
  std::vector<std::unique_ptr<Body>> fixed_, giving_way_, opposite_;  // of the scenery
  std::vector<Box> giving_way_boxes_, opposite_boxes_;
  glm::vec4 hides_below_{0};
  std::vector<glm::vec3> work_mm_;
  std::vector<const Body*> bodies_;  // chosen
  std::vector<BurBody> burs_;
  TriangleBuffer shaft_, tip_, lines_, glass_, setting_, chips_;
  Shape chip_shape_;  // kept for its memory
  PictureWork work_;
  std::optional<glm::mat4> last_view_;
  int still_ = kStillPictures;  // pictures since the camera moved
  // At rest, and a smaller one while the camera turns. Both keep their buffers.
  Sight still_sight_, turning_sight_;
  std::unique_ptr<Sight> reflected_;  // null: nothing is reflected
  std::unique_ptr<Target> result_;    // at the window's size
};

}  // namespace enamel::station::render
