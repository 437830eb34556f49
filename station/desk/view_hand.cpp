#include "station/desk/view_hand.h"

#include <cmath>

namespace enamel::station::desk {

void ViewHand::Look(bool held, const dvec3& hand_m, render::Camera& camera) {
  if (held && last_m_) {
    // The picture is two radii high, and its y points down.
    const glm::vec3 moved = glm::vec3(hand_m - *last_m_) * (1e3f / (2 * camera.radius_mm()));
    const glm::vec3 right = camera.Right(), up = glm::cross(camera.TowardViewer(), right);
    camera.Orbit(glm::dot(moved, right), -glm::dot(moved, up));
  }
  last_m_ = held ? std::optional(hand_m) : std::nullopt;
}

int ViewHand::Quarters(bool turning, const render::Camera& camera) {
  constexpr float kQuarter = std::numbers::pi_v<float> / 2;
  const float turned = camera.Turned();
  const float off = std::remainder(turned - static_cast<float>(quarters_) * kQuarter, 4 * kQuarter);
  if (!turning && std::abs(off) > kQuarter / 2 + kSlack_rad) {
    quarters_ = (static_cast<int>(std::lround(turned / kQuarter)) + 4) % 4;
  }
  return quarters_;
}

}  // namespace enamel::station::desk
