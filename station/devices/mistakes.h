#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/cutting/volume.h"
#include "station/devices/cavity_plan.h"

// How a simulated person of less than full skill errs. Pure functions, any thread.
//
// The lack of skill L of a rank r from 1 to 7 is 0.75^(r - 1); rank 8 lacks none. Each step of
// practice takes the same share of what is left to learn (Heathcote, Brown and Mewhort 2000, "The
// power law repealed": an exponential function fits single learners better than a power in 40 sets
// of data). Luck is a factor of L as well, so it blurs all steps alike.
//
// L is a spread of five things and a number of mistakes. u is a number from -1 to 1, evenly
// distributed; each u below is a draw of its own, from the seed alone:
//   aim and depth  each wall and the floor is off by L 0.24 mm (1 + |u|), in the direction of u
//   angle          the bur leans to buccal or lingual by L 2 degrees u
//   pace           feeds are 1 + 0.4 L u times a calm person's, the push 1 + 0.4 L u times
//   tremor         1 + 3 L times a calm person's
//   mistakes       1 + floor(3 L) of the five kinds; with the same seed the less skilled make those
//                  of the more skilled, and more. s = L (1.25 + 0.25 u):
//     over-extension   one wall or the floor is s 0.45 mm too far
//     untouched part   s 0.45 mm in front of another is left
//     tilt             the bur leans by s 5 degrees
//     gouge            the bur sinks s 0.4 mm into what has to stay
//     wrong order      one step of the first half is done last
// A side beside a neighbour errs by a third, and at most half is left of what lies before the
// opposite one (operators.cpp): contact and caries are seen.
// So nobody who errs is ever without an error, and no error is more than twice another of the same
// kind and skill: an attempt tells skill. A person's own attempts differ more than that.
//
// Sources: the figures are chosen. Rank 7 is 0.04 to 0.09 mm off, rank 1 0.24 to 0.68. 0.1 mm is
// what an eye just sees at the length of an arm (common/scene/builtin/rubrics.cpp), 0.4 mm what
// nobody overlooks. The bur leans across the row of teeth: along it the neighbours guide the hand.
// No published spread of such errors by skill is used.
namespace enamel::station {

// How far beyond the target each side is cut; negative: how much is left.
struct SideErrors {
  double mesial_m = 0, distal_m = 0, buccal_m = 0, lingual_m = 0, floor_m = 0;
};
SideErrors Scaled(const SideErrors& errors, double by);

// A number from -1 to 1, evenly distributed, for a seed and a side below 8.
double Draw(uint64_t seed, uint64_t side);

struct Gouge {
  double at_x = 0, at_y = 0;  // in the target's box, -1 to 1
  double deep_m = 0;
};
struct Mistakes {
  SideErrors sides;
  double lean_deg = 0;  // of the bur's upper end to buccal; negative: to lingual
  double speed_ratio = 1, push_ratio = 1, tremor_ratio = 1;
  std::optional<Gouge> gouge;
  // Which of the steps that can change places is done last, 0 to 1; none: all in order.
  std::optional<double> done_last;
};
// The highest rank.
inline constexpr int kFullSkill = 8;
// 0 for kFullSkill, and for 0: a hand without a rank.
double LackAt(int rank);
// `lack` 0: no mistakes. The same arguments, the same bits.
Mistakes MistakesOf(double lack, uint64_t seed);

// The bur sinks into the finished tooth at a place of the target's box: from above, and up again.
Stroke GougeStroke(const Gouge& gouge, const Bounds& extent, const cutting::Bur& bur,
                   const cutting::Volume& prepared, double clear_m);

// One step of the plan's first half is done after all others. `clear_m`: height above everything,
// for the way there. Returns a plan unchanged where no step can be moved.
std::vector<Move> OutOfOrder(std::vector<Move> plan, double which, double clear_m);

}  // namespace enamel::station
