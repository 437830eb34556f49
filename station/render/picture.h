#pragma once

#include <glm/mat4x4.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "common/cutting/bur.h"
#include "station/render/gl_objects.h"
#include "station/render/mesher.h"

namespace enamel::station::render {

// What to draw in one frame; millimetres, scene frame.
struct PictureState {
  glm::mat4 view_from_scene{1}, clip_from_view{1};
  std::optional<glm::mat4> scene_from_bur;    // none: not drawn
  std::optional<glm::mat4> scene_from_ghost;  // only with scene_from_bur
  glm::vec3 arrow_from_mm{0}, arrow_mm{0};    // zero: no arrow
  float bur_spin = 0;                         // rad
};

// The solid part of the picture, by OpenGL 3.3. Draws into a buffer of its own, which the panel is
// then drawn over. Needs the context current. Not thread-safe.
class Picture {
 public:
  // Throws std::runtime_error when the driver refuses something.
  Picture(const cutting::Bur& bur, size_t group_count);

  void Replace(const GroupMesh& mesh);
  // `oversampling` 1 or 2: solid pixels per picture pixel along each side.
  void Draw(const PictureState& state, int width, int height, int oversampling);
  // Valid after Draw.
  const Target& result() const { return *result_; }

 private:
  bool MayBeSeen(const Bounds& bounds, const PictureState& state) const;
  void Resize(int width, int height, int oversampling);
  void DrawSolids(const PictureState& state);
  void DrawBur(const PictureState& state, const glm::mat4& scene_from_bur, int parts);
  void DrawOcclusion(const PictureState& state);
  void Compose(const PictureState& state);
  void DrawArrow(const PictureState& state);

  Program solid_, occlusion_, blur_, compose_;
  struct Group {
    TriangleBuffer triangles;
    Bounds bounds;
  };
  std::vector<std::unique_ptr<Group>> groups_;
  TriangleBuffer bur_head_, bur_shank_, shaft_, tip_;
  float bur_height_mm_;
  GLuint empty_array_ = 0;
  std::unique_ptr<Target> solids_, occluded_, blurred_, result_;
};

}  // namespace enamel::station::render
