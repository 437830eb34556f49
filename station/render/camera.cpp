#include "station/render/camera.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace enamel::station::render {
namespace {

constexpr float kFieldOfView = glm::radians(28.0f);  // narrow: little perspective distortion
// Short of the pole, where up and the line of sight would coincide.
constexpr float kMaxPitch = glm::radians(89.9f);

glm::vec3 Direction(float yaw, float pitch) {
  return {std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), std::sin(pitch)};
}

}  // namespace

Camera::Camera(const glm::vec3& focus_mm, float radius_mm, float aside, int mesial_x)
    : home_mm_(focus_mm),
      focus_mm_(focus_mm),
      home_radius_mm_(radius_mm),
      radius_mm_(radius_mm),
      aside_(aside),
      mesial_x_(mesial_x) {
  SetView(View::kOblique);
}

void Camera::SetView(View view) {
  focus_mm_ = home_mm_;
  radius_mm_ = home_radius_mm_;
  // Yaw 0 looks from +x, 90 from +y (buccal).
  auto place = [&](float yaw_deg, float pitch_deg) {
    yaw_ = glm::radians(yaw_deg);
    pitch_ = std::clamp(glm::radians(pitch_deg), -kMaxPitch, kMaxPitch);
  };
  switch (view) {
    case View::kOblique:
      return place(mesial_x_ > 0 ? -64 : -116, 55);
    case View::kOcclusal:
      return place(-90, 90);
    case View::kBuccal:
      return place(90, 8);
    case View::kMesial:
      return place(mesial_x_ > 0 ? 0 : 180, 8);
  }
}

void Camera::LookAt(const glm::vec3& point_mm, const glm::vec3& toward_viewer, float radius_mm) {
  // Straight from above, where any way round will do: as SetView(kOcclusal) does.
  SetView(View::kOcclusal);
  focus_mm_ = point_mm;
  radius_mm_ = radius_mm;
  const glm::vec3 to = glm::normalize(toward_viewer);
  const float aside = std::hypot(to.x, to.y);
  if (aside > 1e-3f) yaw_ = std::atan2(to.y, to.x);
  pitch_ = std::clamp(std::atan2(to.z, aside), -kMaxPitch, kMaxPitch);
}

void Camera::Orbit(float dx, float dy) {
  yaw_ -= dx * 4;
  pitch_ = std::clamp(pitch_ + dy * 4, -kMaxPitch, kMaxPitch);
}

void Camera::Pan(float dx, float dy) {
  glm::mat4 view = ViewFromScene();
  glm::vec3 up(view[0][1], view[1][1], view[2][1]);
  focus_mm_ += (-dx * Right() + dy * up) * (2 * radius_mm_);
}

void Camera::Zoom(float notches) {
  radius_mm_ = std::clamp(radius_mm_ * std::pow(0.9f, notches), 0.3f, 60.0f);
}

glm::vec3 Camera::Right() const {
  glm::mat4 view = ViewFromScene();
  return {view[0][0], view[1][0], view[2][0]};
}

float Camera::Turned() const { return std::atan2(Right().y, Right().x); }

glm::vec3 Camera::TowardViewer() const { return Direction(yaw_, pitch_); }

float Camera::distance_mm() const { return radius_mm_ / std::tan(kFieldOfView / 2); }

glm::mat4 Camera::ViewFromScene() const {
  glm::mat4 straight = glm::lookAt(focus_mm_ + distance_mm() * Direction(yaw_, pitch_), focus_mm_,
                                   glm::vec3(0, 0, 1));
  return glm::translate(glm::mat4(1), glm::vec3(2 * radius_mm_ * aside_, 0, 0)) * straight;
}

std::optional<glm::vec2> Camera::Away(const glm::vec3& point_mm, float aspect) const {
  const glm::vec4 clip = ClipFromView(aspect) * ViewFromScene() * glm::vec4(point_mm, 1);
  if (clip.w > 0 && std::abs(clip.x) <= clip.w && std::abs(clip.y) <= clip.w) return std::nullopt;
  // Behind the viewer the projection has the other sign; x and y before the division have not.
  const glm::vec2 away(clip.x * aspect, -clip.y);
  const float length = glm::length(away);
  return length > 0 ? away / length : glm::vec2(0, 1);
}

glm::mat4 Camera::ClipFromView(float aspect) const {
  // An upright picture is as wide as another is high.
  const float upright = 2 * std::atan(std::tan(kFieldOfView / 2) / std::min(aspect, 1.0f));
  return glm::perspective(upright, aspect, near_mm(), far_mm());
}

}  // namespace enamel::station::render
