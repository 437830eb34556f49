#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "station/render/camera.h"

namespace enamel::station::render {

struct Shape;

// Plane mouth mirror of size 4, which makers give as 22 mm across: the usual one.
inline constexpr float kMirrorRadius_mm = 11;

// The mirror in the other hand, its place and its tilt. It belongs to the
// picture alone: nothing collides with it, nothing records it. Moved, it turns so that the viewer
// sees the place of work in it; tilted, it looks around that. Millimetres, scene frame. Not
// thread-safe.
class MouthMirror {
 public:
  // `work_mm`: the place of work. `crown_aside`: the crown is toward -y, a face of it is up.
  explicit MouthMirror(const glm::vec3& work_mm, bool crown_aside = false)
      : work_mm_(work_mm), crown_aside_(crown_aside) {}

  bool shown() const { return shown_; }
  // Shown, it begins beside the place of work, on the picture's free side (Camera::free_side), and
  // behind it, or beyond a crown that is aside: nowhere in the gingiva. `camera` draws back meanwhile.
  void Show(bool shown, Camera& camera);
  // In the picture's plane, as fractions of the picture's height: right, down.
  void Move(float dx, float dy, const Camera& camera);
  // Away from the viewer.
  void Push(float mm, const Camera& camera);
  // Turns about its upright and its level axis, rad: to the picture's right, and up.
  void Tilt(float right, float up, const Camera& camera);
  // The glass is a disc about the frame's middle; +z is out of it, +y toward the hand.
  glm::mat4 SceneFromMirror() const;

 private:
  void Aim(const Camera& camera);

  glm::vec3 work_mm_, middle_mm_{0}, normal_{0, 0, 1}, hand_{0, 1, 0};
  bool crown_aside_ = false, shown_ = false;
};

// From a point to its image in the mirror, scene frame.
glm::mat4 Reflection(const glm::mat4& scene_from_mirror);

// The mirror's bodies, in its own frame: the glass; its setting and handle.
Shape GlassShape();
Shape SettingShape();

}  // namespace enamel::station::render
