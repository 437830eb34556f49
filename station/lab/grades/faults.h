#pragma once

#include <string>
#include <vector>

#include "common/scene/builtin/builtin.h"
#include "station/lab/grades/hollow.h"

// Attempts with known faults, made by formula from what an exercise asks for: the one generator that
// the lab, the tests and their tables of points use.
// Thread safety: functions, any thread. Not real-time.
namespace enamel::station::lab {

// What a perfect hand would take out in this exercise: a box for cavities and caries, the shape of a
// practice block, the reduction for a crown.
struct Task {
  enum class Kind { kBox, kShape, kCrown };
  Kind kind = Kind::kBox;
  BoxCavity box;             // kBox
  scene::Preparation shape;  // kShape
  CrownCut crown;            // kCrown
  bool open_mesial = false;  // of a box: there is no mesial wall

  double Distance_m(const dvec3& point_m) const;
};
// Errors: kInvalidInput when the landmark is not in the scene.
Result<Task> TaskOf(const scene::BuiltScene& built, const scene::Exercise& exercise);

// An attempt with one fault. `metric` is the one that must find it; it should then be `size`.
struct Fault {
  std::string name;    // "wall_mesial", "none", "nothing"
  double size = 0;     // in `unit`; of a volume what was measured of it by points (VolumeWhere_m3)
  std::string unit;    // of the metric
  std::string metric;  // that is to find it
  // How far off the metric may be: a quarter of a voxel, of a volume its area times that, half a
  // degree, a percent.
  double tolerance = 0;
  // At or over the threshold of its kind, which we chose: no study says at which size a dentist marks
  // a fault down. It has to cost a point at least.
  bool must_cost = true;
  Hollow taken;
  Neighbours neighbours = Neighbours::kSpared;
};

// Every fault for this exercise. `few`: of each kind one size, its threshold. `built` outlives what is returned.
std::vector<Fault> FaultsOf(const scene::BuiltScene& built, const scene::Exercise& exercise,
                            const Task& task, bool few);

}  // namespace enamel::station::lab
