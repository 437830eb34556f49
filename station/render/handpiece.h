#pragma once

#include <glm/vec3.hpp>

#include "common/math/orientation.h"
#include "station/render/camera.h"
#include "station/render/revolve.h"

// The handpiece around a bur: head, neck and handle of a high-speed contra-angle. It belongs to the
// picture alone: nothing collides with it, nothing records it. Millimetres; the bur's frame, whose +z
// is from the tip into the head, with the handle above +x.
namespace enamel::station::render {

// Angle between handle and bur and diameter of the neck as designbyfeel.com asks for ("PD handpieces"),
// diameter of the handle's end and length over all as it allows at most. The head's diameter and
// height are *chosen*: no maker's table was read.
inline constexpr float kHandleAngle_deg = 105, kNeckRadius_mm = 4.5f, kHandleEndRadius_mm = 7,
                       kHandpieceLength_mm = 133, kHeadRadius_mm = 5.5f, kHeadHeight_mm = 13;

// The handpiece depends on how high the bur's cutting part is, mm. From the tip to the head's lower
// face: the bur's neck and some of its shank are seen below it (*chosen*).
constexpr float HeadFrom_mm(float bur_height_mm) { return bur_height_mm + 6; }

Shape HandpieceShape(float bur_height_mm);

// The angle about the bur's axis by which a person's handle stands, rad, in the bur's frame: out of
// the picture at the hand's side (Camera::free_side) and a little toward the viewer, however the bur
// leans; what a device turns about the bur's axis turns the handle.
float HandleAzimuth(const Quat& scene_from_bur, const Camera& camera);

// How opaque a part is that is drawn as glass.
inline constexpr float kGlass = 0.15f;
// kGlass where the handpiece hides the bur's tip, and 1 where the line of sight passes it with room to
// spare. `eye_mm`: the viewer, in the handpiece's frame (the handle above +x).
float HandpieceOpacity(float bur_height_mm, const glm::vec3& eye_mm);

}  // namespace enamel::station::render
