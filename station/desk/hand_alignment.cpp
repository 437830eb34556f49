#include "station/desk/hand_alignment.h"

#include <cmath>
#include <numbers>

namespace enamel::station::desk {

std::optional<Standing> StandingOf(const dvec3& moved_m) {
  if (std::hypot(moved_m.x, moved_m.y) < kWayToTheRight_m) return std::nullopt;
  if (std::abs(moved_m.z) > kWayToTheRight_m / 2) return std::nullopt;
  // To a device that is turned to the left, the hand goes to the right of where it faces by as much.
  const int turned_deg =
      -static_cast<int>(std::lround(std::atan2(moved_m.y, moved_m.x) * 180 / std::numbers::pi));
  const int quarters = static_cast<int>(std::lround(turned_deg / 90.0));
  return Standing{(quarters + 4) % 4 * 90, turned_deg - 90 * quarters};
}

}  // namespace enamel::station::desk
