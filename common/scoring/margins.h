#pragma once

#include "common/scoring/shape.h"

// Where the faces of a cut meet: its floor and walls in the line angles inside, its walls and the
// tooth's surface in the margin.
// Deterministic. Thread safety: functions, any thread.
namespace enamel::scoring {

// The round between the floor and each wall. On the bisector from the corner in which the planes of
// attempt's wall and floor meet, its surface begins at a gap g: a round of radius r that touches
// both has g = r (1 / sin(a/2) - 1), where a is the angle between the planes on the cavity's side.
// Looked at in 21 places of each wall's middle half, where the upright edges' rounds do not reach.
struct LineAngleFigures {
  bool in_task = false;  // the reference has a floor and a wall
  bool made = false;     // the attempt has them, and a corner at half of the places
  double radius_m = 0;   // median of the places
};
LineAngleFigures MeasureLineAngles(const CutSide& attempt, const Walls& walls,
                                   const OpenBox& target);

// The angle through the tooth between its surface and the wall that was cut, at each point of the
// outline (OutlineOf in shape.h). It is 180 degrees less the angle between the tooth's outward
// direction at the point and the wall's direction three voxels (at least 0.1 mm) under it. 90:
// upright; more: the wall opens outwards.
struct MarginFigures {
  bool in_task = false;  // the reference has an outline
  bool made = false;     // and the attempt has one
  double angle_deg = 0;  // median over the reference's outline of the attempt's nearest
  double worst_deg = 0;  // 95 % of that outline differ from the reference's own by no more
};
MarginFigures MeasureMargin(const cutting::Volume& initial, const CutSide& attempt,
                            const CutSide& reference);

}  // namespace enamel::scoring
