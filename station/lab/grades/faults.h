#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/scene/builtin/builtin.h"
#include "station/lab/grades/hollow.h"

// Attempts with known faults, made by formula from an exercise's target: the one generator for the
// lab, the tests and their tables of points. Thread safety: functions, any thread. Not real-time.
namespace enamel::station::lab {

// What a perfect hand would remove in this exercise: a box for cavities and caries, the shape of a
// practice block, the reduction for a crown.
struct Task {
  enum class Kind { kBox, kShape, kCrown };
  Kind kind = Kind::kBox;
  BoxCavity box;             // kBox
  scene::Preparation shape;  // kShape
  CrownCut crown;            // kCrown
  bool open_mesial = false;  // of a box: there is no mesial wall

  double Distance_m(const dvec3& point_m) const;
  // To the task with its surface moved into the solid by `by_m`, out of it where that is below 0. Continuous on that
  // surface, where the distance from a relief is not.
  double GrownDistance_m(const dvec3& point_m, double by_m) const;
};
// Errors: kInvalidInput when the landmark is not in the scene.
Result<Task> TaskOf(const scene::BuiltScene& built, const scene::Exercise& exercise);

// An attempt with one fault. `metric` must find it, with the value `size`.
struct Fault {
  std::string name;    // "wall_mesial", "none", "nothing"
  double size = 0;     // in `unit`; a volume's is measured by points (VolumeWhere_m3)
  std::string unit;    // of the metric
  std::string metric;  // the metric that must find it
  // Allowed error of the metric: a quarter of a voxel, for a volume its area times that, half a
  // degree, a percent.
  double tolerance = 0;
  // At or over the threshold of its kind, so it must cost at least a point. We chose the
  // thresholds: no study gives the size at which a dentist deducts marks.
  bool must_cost = true;
  Hollow taken;
  Neighbours neighbours = Neighbours::kSpared;
  std::string critical = {};  // the error of schemas/critical_errors.json that it commits, if any
  double nick_mm = 0;         // of a neighbour that is cut: how deep
  // What it may cost at most, of a hundred: an examiner's eye does not see 0.08 mm.
  std::optional<double> may_cost = {};
};

// Every fault for this exercise. `few`: one size of each kind, its threshold. `built` outlives the
// result.
std::vector<Fault> FaultsOf(const scene::BuiltScene& built, const scene::Exercise& exercise,
                            const Task& task, bool few);

}  // namespace enamel::station::lab
