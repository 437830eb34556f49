#pragma once

#include <array>
#include <optional>

#include "common/scene/types.h"
#include "common/scoring/shape.h"

// A crown's preparation: the walls that converge towards the top, what was taken off, and the
// finish line all around. Formulas and sources: schemas/score.md, "Crown". Deterministic. Thread
// safety: functions, any thread.
namespace enamel::scoring {

// The cut over a cusp's outer side, between table and wall: what falls outwards at 30 to 65 degrees
// to the level. In the half planes within 25 degrees of buccal or lingual.
struct BevelFigures {
  bool made = false;     // half of the half planes have 0.2 mm of it
  double width_m = 0;    // along the surface: median
  double angle_deg = 0;  // to the level: median
};

// Measured in half planes about an upright axis through the middle of the reference's stump. The
// reference fixes where finish line, walls and top are; the figures are the attempt's.
struct CrownFigures {
  bool in_task = false;  // the reference has a finish line and walls of a millimetre all around
  bool made = false;     // the attempt has walls there, in every half plane

  // Angle between the two walls of a section, degrees: + they meet above the top. From mesial to
  // distal, from buccal to lingual, and of these and the six sections between them.
  double mesiodistal_deg = 0, buccolingual_deg = 0, least_deg = 0, most_deg = 0;
  double axis_deg = 0;  // how far the middle line between the walls leans from +z
  double undercut_m2 =
      0;  // area of the walls that leans out over the finish line by over 2 degrees
  // The most by which the straight lines through the two walls of a section come nearer to each
  // other downwards: no crown seats over it, however it is turned.
  double overhang_m = 0;
  // The least share of the reference's reduction, of the walls that it reduced by 0.5 mm.
  double least_wall = 0;
  std::array<double, 4> wall_m{};  // taken off: mesial, distal, buccal, lingual; median over height
  double top_m = 0, top_least_m = 0;  // off the top, straight down: median, and what 95 % exceed

  // The finish line's, at 72 places.
  double width_m = 0, width_least_m = 0;  // median, and what 95 % exceed
  double depth_m = 0;                     // median below the reference's; - above
  double waviness_m = 0;                  // RMS of that about its median
  // The same of the places with a width of at least 0.3 mm; 0 without any.
  double waviness_made_m = 0;
  double missing_deg = 0;  // longest stretch narrower than 0.1 mm or 0.75 mm too high
  double complete = 0;     // share of the places with a width of at least 0.3 mm

  BevelFigures bevel_buccal, bevel_lingual;
};

// `bottom_z_m`: where the exercise puts the shoulder, within 1.5 mm. `mesial_x`: scene::MesialX.
CrownFigures MeasureCrown(const cutting::Volume& initial, const CutSide& attempt,
                          const CutSide& reference, const dvec3& landmark_m, double bottom_z_m,
                          int mesial_x);

// The exercise may ask for a crown: its target is a stump, or hangs from a crown's top, or is a
// prepared tooth, of which CrownFigures::in_task says whether it is one.
bool IsCrown(const scene::CavityTarget& target);

}  // namespace enamel::scoring
