#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "common/cutting/bur.h"
#include "common/math/orientation.h"
#include "station/render/camera.h"
#include "station/render/revolve.h"

// The handpiece around a bur: head, neck and handle of a high-speed contra-angle. It belongs to the
// picture alone: nothing collides with it, nothing records it. Millimetres; the bur's frame, whose +z
// is from the tip into the head, with the handle above +x.
namespace enamel::station::render {

// Angle between handle and bur, diameters of the neck and of the handle's end, and the length over
// all: the specification of a handpiece for precise handling by designbyfeel.com ("PD handpieces").
// The head's diameter and height are *chosen*: 11 and 13 mm, between a small and a large turbine.
inline constexpr float kHandleAngle_deg = 105, kNeckRadius_mm = 4.5f, kHandleEndRadius_mm = 7,
                       kHandpieceLength_mm = 133, kHeadRadius_mm = 5.5f, kHeadHeight_mm = 13;

// From the tip to the head's lower face: neck and shank of the bur are seen below it (*chosen*; a bur
// for it is 19 to 21 mm long by ISO 1797 and goes some 12 mm into the chuck).
float HeadFrom_mm(const cutting::Bur& bur);

Shape HandpieceShape(const cutting::Bur& bur);

// The angle about the bur's axis by which a person's handle stands, rad, in the bur's frame: out of
// the picture at the hand's side (Camera::free_side) and a little toward the viewer, however the bur
// leans; what a device turns about the bur's axis turns the handle.
float HandleAzimuth(const Quat& scene_from_bur, const Camera& camera);

// Where the bur's tip is seen beside the handpiece it is 1, and where the handpiece hides it kGlass. In
// between, the room that is left decides. `eye_mm`: the viewer, in the handpiece's frame (the handle above +x).
inline constexpr float kGlass = 0.16f;
float HandpieceOpacity(const cutting::Bur& bur, const glm::vec3& eye_mm);

}  // namespace enamel::station::render
