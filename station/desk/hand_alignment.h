#pragma once

#include <optional>

#include "common/math/vec.h"

namespace enamel::station::desk {

// How a device stands on its table: `turn_deg` counter-clockwise from above, 0, 90, 180 or 270, and `askew_deg`
// more, -45 to 45.
struct Standing {
  int turn_deg = 0, askew_deg = 0;

  // More than a hand's way to the right is crooked: the forearm turns about an elbow some 300 mm away, so that the
  // chord of 40 mm leans by 4 degrees, and by as much again where it is begun or ended off the middle.
  bool IsAskew() const { return askew_deg < -kCrooked_deg || askew_deg > kCrooked_deg; }
  static constexpr int kCrooked_deg = 10;
};

inline constexpr double kWayToTheRight_m = 40e-3;

// From how far the device says a hand has gone that went to its person's right; x, y, z: the device's own axes, z
// up. Nothing before it has gone kWayToTheRight_m, or while it has gone up or down by half of that. Any thread,
// real-time safe.
std::optional<Standing> StandingOf(const dvec3& moved_m);

// Awaits such a way. Thread safety: owner's thread.
class HandAlignment {
 public:
  // From where the hand is now.
  void Begin(const dvec3& hand_m) {
    from_m_ = hand_m;
    found_.reset();
  }
  // Once a frame. True: it has just been found.
  bool Look(const dvec3& hand_m) {
    if (!awaits_hand()) return false;
    found_ = StandingOf(hand_m - *from_m_);
    return found_.has_value();
  }
  bool awaits_hand() const { return from_m_ && !found_; }
  const std::optional<Standing>& found() const { return found_; }

 private:
  std::optional<dvec3> from_m_;
  std::optional<Standing> found_;
};

}  // namespace enamel::station::desk
