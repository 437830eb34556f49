#pragma once

#include <string>

#include "station/lab/grades/hollow.h"

// Pictures of a tooth that was cut open. Thread safety: functions, any thread. Not real-time.
namespace enamel::station::lab {

// What the plane of a section shows; the scene's x is mesiodistal, y buccolingual, z upright.
enum class Plane { kMesiodistal, kBuccolingual, kLevel };

// A tooth with the cavity that was wanted and the cavity that was cut.
struct CutPair {
  const cutting::Volume* tooth = nullptr;
  Hollow wanted, taken;
  Neighbours neighbours = Neighbours::kSpared;  // of `taken`
};

// Two sections side by side as an SVG element: the tooth after `wanted`, and after `taken`. They lie
// where the two differ visibly, as near the middle of the cut as that allows. In the second, class
// "over" is what was removed and should have stayed, "left" is what stayed and should have been
// removed, and "should" is the line of `wanted`; the other classes are tissues. Empty: the two do not
// differ.
std::string DrawSections(const CutPair& cut, Plane plane);

}  // namespace enamel::station::lab
