#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/fidelity/random.h"
#include "common/fidelity/way.h"

// Hand motions while cutting: paths in space sampled once a millisecond. Recorded ones come from a
// folder of CSV files; the others are generated, and identical on every machine for a seed.
//
// A path begins and ends at rest unless its name says otherwise. SI units.
namespace enamel::station::lab {

struct HandMotion {
  std::string name;
  std::vector<dvec3> way_m;  // one position per kWayStep_s, from time 0
  double reversal_s = -1;    // when it turns straight back, -1: it does not
  bool human = false;        // recorded from a person
};

using fidelity::kWayStep_s;
using fidelity::Random;
using fidelity::WayReader;

// Length of the way over its duration.
double MeanSpeed(const HandMotion& motion);
// The same path, scaled to this mean speed; the duration does not change.
HandMotion ScaledToSpeed(HandMotion motion, double mean_m_per_s);

// Straight and back at constant speed: `out_s` there, `back_s` back, no rest between.
HandMotion ReversalMotion(double speed_m_per_s, double out_s, double back_s,
                          const dvec3& direction);
// To and fro between two points with minimum-jerk strokes of `stroke_s` each (Flash and Hogan 1985:
// s(t) = L (10 u^3 - 15 u^4 + 6 u^5), u = t / stroke_s), mean speed as given.
HandMotion StrokesMotion(double mean_m_per_s, double stroke_s, int strokes, const dvec3& direction);
// Once and a half around a circle at constant speed, in a plane oblique to the axes.
HandMotion CircleMotion(double speed_m_per_s, double radius_m);
// Straight on, then at a right angle, at constant speed.
HandMotion CornerMotion(double speed_m_per_s, double leg_s);
// Straight at constant speed, with tremor of the amplitude across and along, 8 to 12 Hz.
HandMotion TremorMotion(double speed_m_per_s, double amplitude_m, double duration_s, uint64_t seed);
// A hand that works a surface: minimum-jerk strokes of random length, direction and pause, with
// tremor; as smooth and varied as a person's, but of known statistics. The recipe: strokes of 0.3 to
// 2 s, evenly in the logarithm, each at 0.3 to 2 of a unit speed; a third are followed by a pause of
// 0.05 to 0.5 s; half lead back near the start; tremor of 9, 10 and 11 Hz along x, y and z with an
// amplitude of 1/500 of a stroke of a second at unit speed; all scaled to the mean speed.
HandMotion WanderingMotion(double mean_m_per_s, double duration_s, uint64_t seed);

// The file `folder`, or every `*.csv` under it (at most 64 files of 4 MiB), with columns t_s, px_m, py_m, pz_m at 1
// kHz. Positions are Smoothed. Empty
// if there is no such file or folder. Errors: kInvalidInput with file and line.
Result<std::vector<HandMotion>> RecordedMotions(const std::string& folder);

}  // namespace enamel::station::lab
