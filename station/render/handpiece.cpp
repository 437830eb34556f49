#include "station/render/handpiece.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace enamel::station::render {
namespace {

// The neck ends, and the handle reaches its full width, so far from the bur's axis (*chosen*).
constexpr float kNeckEnd_mm = 22, kFull_mm = 62;
// The head's edges lie within spheres about points of its axis so far from its ends.
constexpr float kRounding_mm = 3;
// Where a line of sight passes the handpiece by this much, the handpiece is opaque (*chosen*).
constexpr float kRoom_mm = 2.5f;

// Out of the head, in the handle's frame: by the angle to the bur, which points along -z.
glm::vec3 HandleDirection() {
  const float above_level = glm::radians(kHandleAngle_deg - 90);
  return {std::cos(above_level), 0, std::sin(above_level)};
}

float Middle_mm(float bur_height_mm) { return HeadFrom_mm(bur_height_mm) + 0.5f * kHeadHeight_mm; }

// Least distance between the segments from p over u and from q over v: closest points of two lines,
// each kept within its segment.
float Apart(const glm::vec3& p, const glm::vec3& u, const glm::vec3& q, const glm::vec3& v) {
  const glm::vec3 w = p - q;
  const float uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v), uw = glm::dot(u, w),
              vw = glm::dot(v, w);
  const float parallel = uu * vv - uv * uv;
  float s = parallel > 1e-6f ? std::clamp((uv * vw - vv * uw) / parallel, 0.0f, 1.0f) : 0.0f;
  const float t = std::clamp((uv * s + vw) / vv, 0.0f, 1.0f);
  s = std::clamp((uv * t - uw) / uu, 0.0f, 1.0f);
  return glm::length(w + s * u - t * v);
}

}  // namespace

Shape HandpieceShape(float bur_height_mm) {
  const float low = HeadFrom_mm(bur_height_mm), high = low + kHeadHeight_mm, r = kHeadRadius_mm;
  Shape out = Revolve({{0, low},
                       {0.45f * r, low},
                       {0.85f * r, low + 0.8f},
                       {r, low + 2.2f},
                       {r, high - 3.4f},
                       {0.92f * r, high - 1.6f},
                       {0.74f * r, high - 0.9f},
                       {0.70f * r, high - 0.3f},  // the button that frees the bur
                       {0.62f * r, high},
                       {0, high}},
                      kBurShank);
  const float length = kHandpieceLength_mm - r;
  const Shape handle = Revolve({{kNeckRadius_mm, 0},
                                {kNeckRadius_mm, kNeckEnd_mm},
                                {0.86f * kHandleEndRadius_mm, 0.5f * (kNeckEnd_mm + kFull_mm)},
                                {kHandleEndRadius_mm, kFull_mm},
                                {kHandleEndRadius_mm, length},
                                {0, length}},
                               kBurShank);
  // +z along the handle.
  glm::mat4 at = glm::translate(glm::mat4(1), glm::vec3(0, 0, Middle_mm(bur_height_mm)));
  at = glm::rotate(at, glm::radians(180 - kHandleAngle_deg), glm::vec3(0, 1, 0));
  Append(handle, at, out);
  return out;
}

float HandleAzimuth(const Quat& scene_from_bur, const Camera& camera) {
  glm::vec3 toward = camera.TowardViewer();
  toward.z = 0;
  const glm::vec3 side = 0.92f * camera.free_side() * camera.Right() +
                         0.39f * toward / std::max(glm::length(toward), 0.1f);
  // The orientation without its turn about the bur's own axis (swing and twist): a level handle's
  // place, which that turn then carries along, since the handle is drawn in the bur's frame.
  const double turn = std::hypot(scene_from_bur.z, scene_from_bur.w);
  Quat swing = scene_from_bur;
  if (turn > 0) swing = swing * Quat{0, 0, -scene_from_bur.z / turn, scene_from_bur.w / turn};
  const dmat3 m = swing.Normalised().Matrix();
  return std::atan2(glm::dot(glm::vec3(m[1]), side), glm::dot(glm::vec3(m[0]), side));
}

float HandpieceOpacity(float bur_height_mm, const glm::vec3& eye_mm) {
  const float low = HeadFrom_mm(bur_height_mm);
  // Capsules around head, neck and handle.
  const glm::vec3 head(0, 0, low + kRounding_mm), up(0, 0, kHeadHeight_mm - 2 * kRounding_mm),
      middle(0, 0, Middle_mm(bur_height_mm)), out = HandleDirection(), neck = kNeckEnd_mm * out,
                                              handle = (kHandpieceLength_mm - kNeckEnd_mm) * out;
  const glm::vec3 tip(0);
  float room = kRoom_mm;
  room = std::min(room, Apart(tip, eye_mm, head, up) - kHeadRadius_mm);
  room = std::min(room, Apart(tip, eye_mm, middle, neck) - kNeckRadius_mm);
  room = std::min(room, Apart(tip, eye_mm, middle + neck, handle) - kHandleEndRadius_mm);
  const float free = std::clamp(room / kRoom_mm, 0.0f, 1.0f);
  return kGlass + (1 - kGlass) * free * free * (3 - 2 * free);
}

}  // namespace enamel::station::render
