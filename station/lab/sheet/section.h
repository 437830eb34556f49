#pragma once

#include <string>

#include "station/lab/grades/hollow.h"

// Pictures of a tooth that was cut open. Thread safety: functions, any thread. Not real-time.
namespace enamel::station::lab {

// What the plane of a section shows; the scene's x is mesiodistal, y buccolingual, z upright.
enum class Plane { kMesiodistal, kBuccolingual, kLevel };

// A tooth, what had to be removed from it, and what was.
struct CutPair {
  const cutting::Volume* tooth = nullptr;
  Hollow wanted, taken;
  Neighbours neighbours = Neighbours::kSpared;  // of `taken`
};

// Two sections side by side as an SVG element: the tooth after `wanted`, and after `taken`. They lie
// where the two differ visibly, as near the middle of the cut as that allows. The second marks what was cut too much (class "over"), what was left
// ("left") and where the cut should end ("should"); the other classes are tissues. Empty: they do
// not differ.
std::string DrawSections(const CutPair& cut, Plane plane);

}  // namespace enamel::station::lab
