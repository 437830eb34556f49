#include "station/render/mouth_mirror.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "station/render/revolve.h"

namespace enamel::station::render {
namespace {

// Where it is at first, from the place of work: beside and behind it, its rim clear of a molar of
// 11 mm, so that the handpiece has room before it.
constexpr float kBeside_mm = 11, kBehind_mm = 5, kAbove_mm = 3;
constexpr glm::vec3 kBeyondCrown_mm{0, -13, 3};
constexpr float kBesideCrown_mm = 6;
// The picture draws back to have room for it, in notches of the wheel: 1.37 times as much is seen.
constexpr float kRoom = 3;
// It stays in the mouth: within reach of the place of work.
constexpr float kReach_mm = 40;

glm::vec3 EyeOf(const Camera& camera) { return glm::vec3(glm::inverse(camera.ViewFromScene())[3]); }

glm::vec3 UpOf(const Camera& camera) { return glm::cross(camera.TowardViewer(), camera.Right()); }

glm::vec3 Turned(const glm::vec3& v, float angle, const glm::vec3& axis) {
  return glm::vec3(glm::rotate(glm::mat4(1), angle, axis) * glm::vec4(v, 0));
}

}  // namespace

void MouthMirror::Show(bool shown, Camera& camera) {
  if (shown == shown_) return;
  shown_ = shown;
  camera.Zoom(shown ? -kRoom : kRoom);
  if (!shown) return;
  const glm::vec3 beside = camera.free_side() * camera.Right();
  if (crown_aside_) {
    middle_mm_ = work_mm_ + kBeyondCrown_mm + kBesideCrown_mm * beside;
    return Aim(camera);
  }
  // Level, away from the viewer; from right above that is the picture's upward.
  glm::vec3 away = glm::vec3(UpOf(camera));
  away.z = 0;
  const float length = glm::length(away);
  away = length > 0.1f ? away / length : glm::cross(glm::vec3(0, 0, 1), camera.Right());
  middle_mm_ = work_mm_ + kBeside_mm * beside + kBehind_mm * away + glm::vec3(0, 0, kAbove_mm);
  Aim(camera);
}

void MouthMirror::Move(float dx, float dy, const Camera& camera) {
  middle_mm_ += (dx * camera.Right() - dy * UpOf(camera)) * (2 * camera.radius_mm());
  Aim(camera);
}

void MouthMirror::Push(float mm, const Camera& camera) {
  middle_mm_ -= mm * camera.TowardViewer();
  Aim(camera);
}

void MouthMirror::Tilt(float right, float up, const Camera& camera) {
  normal_ = Turned(normal_, right, UpOf(camera));
  normal_ = glm::normalize(Turned(normal_, -up, camera.Right()));
}

// The law of reflection: the normal halves the angle between eye and work.
void MouthMirror::Aim(const Camera& camera) {
  const glm::vec3 from_work = middle_mm_ - work_mm_;
  const float away = glm::length(from_work);
  if (away > kReach_mm) middle_mm_ = work_mm_ + from_work * (kReach_mm / away);
  const glm::vec3 to_work = work_mm_ - middle_mm_, to_eye = EyeOf(camera) - middle_mm_;
  const glm::vec3 both = glm::normalize(to_eye) + to_work / std::max(glm::length(to_work), 1e-3f);
  // Between the two there is no such normal: it faces the viewer.
  normal_ = glm::length(both) > 1e-3f ? glm::normalize(both) : glm::normalize(to_eye);
  // To the free side and up in the picture: clear of the panel and of the tooth.
  hand_ = 0.8f * camera.free_side() * camera.Right() + 0.6f * UpOf(camera);
}

glm::mat4 MouthMirror::SceneFromMirror() const {
  glm::vec3 y = hand_ - glm::dot(hand_, normal_) * normal_;
  const float length = glm::length(y);
  y = length > 1e-3f ? y / length
                     : glm::normalize(glm::cross(normal_, glm::vec3(0.6f, 0.64f, 0.48f)));
  return glm::mat4(glm::vec4(glm::cross(y, normal_), 0), glm::vec4(y, 0), glm::vec4(normal_, 0),
                   glm::vec4(middle_mm_, 1));
}

// Householder's: p - 2 ((p - middle) . normal) normal.
glm::mat4 Reflection(const glm::mat4& scene_from_mirror) {
  const glm::vec3 normal(scene_from_mirror[2]), middle(scene_from_mirror[3]);
  glm::mat3 turn(1);
  turn -= 2.0f * glm::outerProduct(normal, normal);
  glm::mat4 out(turn);
  out[3] = glm::vec4(2 * glm::dot(middle, normal) * normal, 1);
  return out;
}

Shape GlassShape() { return Revolve({{kMirrorRadius_mm, 0}, {0, 0}}, kBurShank); }

Shape SettingShape() {
  constexpr float kRim_mm = kMirrorRadius_mm + 0.5f;
  Shape out = Revolve({{0, -2.0f},
                       {kRim_mm - 2, -1.8f},
                       {kRim_mm, -0.9f},
                       {kRim_mm, 0.15f},
                       {kMirrorRadius_mm, 0.15f},
                       {kMirrorRadius_mm, 0}},
                      kBurShank);
  // Stem and handle, behind the glass's plane.
  Shape stem = Revolve({{0, 0}, {1.1f, 0}, {0.9f, 14}, {2.0f, 20}, {2.6f, 24}, {2.6f, 80}, {0, 80}},
                       kBurShank);
  // 45 degrees: how makers bend it.
  glm::mat4 at = glm::translate(glm::mat4(1), glm::vec3(0, kRim_mm - 0.6f, -0.6f));
  at = glm::rotate(at, glm::radians(-135.0f), glm::vec3(1, 0, 0));
  Append(stem, at, out);
  return out;
}

}  // namespace enamel::station::render
