#pragma once

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

 private:
  std::optional<dvec3> last_m_;  // while it is held
};

}  // namespace enamel::station::desk
