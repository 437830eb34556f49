#pragma once

#include <functional>
#include <vector>

#include "common/cutting/volume.h"
#include "common/scene/types.h"

// Level outlines that a simulated dentist's bur follows: convex, corners counter-clockwise seen
// from above, metres in the scene frame.
namespace enamel::station {

using Outline = std::vector<glm::dvec2>;

struct Bounds {
  double x0 = 0, x1 = 0, y0 = 0, y1 = 0;
};

Outline RectangleOf(const Bounds& b);  // starts at the corner of least x and y
Bounds BoundsOf(const Outline& outline);
bool IsConvex(const Outline& outline);

// The opening of a box, disc or polygon. A disc has 24 corners; the middles of its sides touch the
// circle.
Outline OutlineOf(const scene::PreparationPart& part);
// A stump's level section at height `z_m`; 16 corners, four for each round one.
Outline SectionOf(const scene::PreparationPart& part, double z_m);

// Every side moved out by `by_m` of its outward direction. Sides that shrink to nothing are
// dropped; empty if nothing is left inside.
Outline Moved(const Outline& outline, const std::function<double(const glm::dvec2&)>& by_m);
Outline Grown(const Outline& outline, double by_m);
// The part of it within the bounds.
Outline Within(const Outline& outline, const Bounds& bounds);
// Radius of the largest circle inside.
double Inradius(const Outline& outline);

// The corners at height `z_m`, starting with the first, in either direction.
std::vector<dvec3> CornersAt(const Outline& outline, double z_m, bool clockwise);

}  // namespace enamel::station
