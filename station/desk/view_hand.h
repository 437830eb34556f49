#pragma once

#include <numbers>
#include <optional>

#include "common/math/vec.h"
#include "station/render/camera.h"

namespace enamel::station::desk {

// Turns the picture by the hand's motion while the device's second button is held: as far as the
// mouse does that drags over the same part of the picture. Thread safety: owner's thread.
class ViewHand {
 public:
  // Once a frame. `hand_m`: where the device is, scene frame.
  void Look(bool held, const dvec3& hand_m, render::Camera& camera);
  // How many quarters the hand's axes have to be turned by for its right to be the picture's, but for
  // an eighth of a turn. The same as before within kSlack_rad of the border between two, and while
  // the picture is being turned: the bur would jump about.
  int Quarters(bool turning, const render::Camera& camera);

  static constexpr float kSlack_rad = std::numbers::pi_v<float> / 18;

 private:
  int quarters_ = 0;
  std::optional<dvec3> last_m_;  // while it is held
};

}  // namespace enamel::station::desk
