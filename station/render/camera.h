#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "station/render/view.h"

namespace enamel::station::render {

// Orbits a focus; millimetres, scene frame (common/scene/types.h). Not thread-safe.
class Camera {
 public:
  // `radius_mm`: half the height of the view at the focus, of an upright picture half its width.
  // `aside`: distance of the focus to the right of the picture's middle, in these heights. `mesial_x`:
  // scene::MesialX.
  Camera(const glm::vec3& focus_mm, float radius_mm, float aside = 0, int mesial_x = 1);

  void SetView(View view);
  // A place seen along a direction (out of what is seen), so near that `radius_mm` fills the view.
  void LookAt(const glm::vec3& point_mm, const glm::vec3& toward_viewer, float radius_mm);
  // Turns by a drag of the mouse, as fractions of the window's shorter side.
  void Orbit(float dx, float dy);
  // Moves the focus in the picture's plane, same unit.
  void Pan(float dx, float dy);
  // One notch of the wheel; positive comes nearer.
  void Zoom(float notches);

  glm::mat4 ViewFromScene() const;
  glm::mat4 ClipFromView(float aspect) const;
  // Unit vectors of the picture, in the scene frame.
  glm::vec3 Right() const;
  glm::vec3 TowardViewer() const;
  // The angle of Right() from +x, counter-clockwise seen from +z, rad.
  float Turned() const;
  // Where a point outside the picture lies, seen from its middle: a unit vector, y down. None: in the
  // picture. `aspect`: its width over its height.
  std::optional<glm::vec2> Away(const glm::vec3& point_mm, float aspect) const;
  float radius_mm() const { return radius_mm_; }
  // The focus as far to the other side of the picture's middle.
  void MirrorAside() { aside_ = -aside_; }
  // 1: the focus is in the picture's middle or right of it, and free is what is at its right; -1: left.
  float free_side() const { return aside_ < 0 ? -1.0f : 1.0f; }
  float near_mm() const { return distance_mm() * 0.05f; }
  float far_mm() const { return distance_mm() + 60; }

 private:
  float distance_mm() const;

  glm::vec3 home_mm_, focus_mm_;
  float home_radius_mm_, radius_mm_;
  float aside_;
  int mesial_x_;
  float yaw_ = 0, pitch_ = 0;  // rad; where the camera is, seen from the focus
};

}  // namespace enamel::station::render
