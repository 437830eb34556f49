#pragma once

#include <array>
#include <bitset>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "common/scoring/movement/process.h"
#include "common/surface/surface.h"

// The metrics of an attempt. schemas/score.md has the formula, unit and source of each; the tests
// have a worked example of each against a closed form.
//
// Deterministic: equal inputs give equal bits; only + - * / sqrt, fixed orders, no threads.
// Thread safety: functions, any thread. Real-time: nothing here is.
namespace enamel::scoring {

// A metric's registry entry. A new metric is one entry in registry/.
struct MetricInfo {
  std::string_view name;  // "wall_mesial_mm"
  std::string_view unit;  // "mm", "mm2", "mm3", "%", "N", "s"
  std::string_view title;
  std::string_view formula;  // one sentence for people
  // Signed metrics only: what a value above and below zero means ("too deep", "too shallow").
  std::string_view above_zero = {};
  std::string_view below_zero = {};
  // What a value means where the device was at its limit: a force of at least the value, or
  // nothing.
  enum class AtLimit { kSame, kAtLeast, kUnknown } at_limit = AtLimit::kSame;
  // The thickness of what is left: the grid measures none below cutting::kThinnestWall_voxels.
  bool thickness = false;
};
std::span<const MetricInfo> Metrics();
const MetricInfo* FindMetric(std::string_view name);  // nullptr when unknown
// Whether the finished tooth shows it: not force, time, way and motion, which the recording alone has.
bool IsSeenOnTheTooth(std::string_view name);

// Everything about one attempt (or reference) that metrics are computed from. Nothing is owned.
// All volumes of one comparison have the same grid.
struct AttemptData {
  const cutting::Volume* initial = nullptr;
  const cutting::Volume* final_volume = nullptr;
  const surface::Mesh* final_surface = nullptr;  // of final_volume
  // Null where a reference was not recorded, but is the tooth that an exercise's target names.
  const ProcessRecorder* process = nullptr;
  // Of the attempt only: DeviationPerVertex of final_surface where the caller has it already;
  // computed when null.
  const std::vector<float>* deviation_m = nullptr;
};

struct MetricValue {
  std::string name;
  double value = 0;
  std::string unit;
  // A metric of force, and the device was at its limit for more than kMaxLimited_percent of the
  // ticks with any force: the hand may have done more than could be rendered.
  bool limited = false;
  // Of a thickness below it: the least that the grid can measure, in the metric's unit. The value
  // may be off by all of it, and 0 may be a wall.
  std::optional<double> below_grid = {};
  // Standard, in the metric's unit (uncertainty.h). None: of the recording, or without a formula.
  std::optional<double> uncertainty = {};

  bool operator==(const MetricValue&) const = default;
};
// Above this, the 95th percentile of the force is the device's bound and not the hand's.
inline constexpr double kMaxLimited_percent = 5;

// The station's part in an attempt. Disturbed where one of them is beyond its limit; the limits are
// chosen, not measured on people.
struct Disturbance {
  static constexpr double kMaxLate_percent = 1, kMaxGaps_percent = 1;
  double late_percent = 0;     // of the ticks
  double gap_percent = 0;      // of the time
  double limited_percent = 0;  // of the ticks with any force: the device's peak bound engaged

  bool disturbed() const {
    return late_percent > kMaxLate_percent || gap_percent > kMaxGaps_percent ||
           limited_percent > kMaxLimited_percent;
  }
  bool operator==(const Disturbance&) const = default;
};
Disturbance DisturbanceOf(const ProcessRecorder& process);

// Parts of the measurement that are done or left out as a whole.
enum class MetricGroup : uint8_t {
  kTask,        // what went, per tissue and against the task
  kDeviation,   // distances between the surfaces
  kRecording,   // time, force, way, contacts, angulation, order of work
  kZones,       // target, leeway, container
  kWalls,       // walls and floor: offset, tilt, waviness
  kOutline,     // on the tooth's surface
  kCover,       // of the pulp; depth in a neighbour
  kMotion,      // smoothness and tremor
  kPathInTime,  // against the reference's path, by time
  kPathByWay,   // and by the bur's way
  kCrown,       // walls about an axis, reduction, finish line, bevel
  kLineAngles,  // between floor and walls
  kMargin,      // between walls and the tooth's surface
};
inline constexpr size_t kMetricGroups = 13;

// The groups that a list of metrics needs. A group is measured for all its metrics at the cost of
// one, so all of a group's are reported.
class MetricPlan {
 public:
  // Page, report and class lists show these of every attempt, whatever its rubric asks for:
  // closeness and its heat map, task, tissues, time and force.
  static constexpr std::array kBaseGroups = {MetricGroup::kTask, MetricGroup::kDeviation,
                                             MetricGroup::kRecording};

  static MetricPlan All();
  // The base, the groups of the rubric's criteria and critical errors, and those that say more of a region that it has a
  // price for. Metrics that do not exist are ignored (ValidateRubric reports them).
  static MetricPlan For(const scene::Rubric& rubric);

  void Add(MetricGroup group) { groups_.set(static_cast<size_t>(group)); }
  bool Has(MetricGroup group) const { return groups_.test(static_cast<size_t>(group)); }

 private:
  std::bitset<kMetricGroups> groups_;
};

// Why a metric has no value.
enum class NoValue {
  kNotInTask,  // this exercise does not ask for it: no caries in its task, no such wall, no recording
               // to compare the way with
  kNotMade,    // it asks, and the attempt has not made what could be measured
  kNotUsed,    // the exercise's plan does not measure it; scoring by another rubric may
};
struct MissingMetric {
  std::string name;
  NoValue why = NoValue::kNotInTask;

  bool operator==(const MissingMetric&) const = default;
};

// Every metric of Metrics() is in one of the lists, in its order.
struct MetricSet {
  std::vector<MetricValue> values;
  std::vector<MissingMetric> missing;

  bool operator==(const MetricSet&) const = default;
};

// Farther deviations are reported as this far: 5 mm, half a crown.
inline constexpr double kDeviationLimit_m = 5e-3;

// Signed deviation (m) of every vertex of `mesh` from the reference surface: positive where more
// was removed than in the reference, negative where less. NaN where the vertex belongs to the
// untouched initial surface in both (nothing was cut there and nothing should have been): where
// neither final volume differs from the initial one by more than a tenth of a voxel.
//
// The magnitude is the distance to the reference's triangles (a volume's own distance saturates at
// four voxels), the sign is the side of the reference volume the vertex lies on.
std::vector<float> DeviationPerVertex(const surface::Mesh& mesh, const cutting::Volume& initial,
                                      const cutting::Volume& final_volume,
                                      const cutting::Volume& reference,
                                      const surface::Mesh& reference_surface);

// The plan's metrics of an attempt against a reference. `progress` (0..1) may be empty; false ends
// the work. Errors: kInvalidInput when grids differ, the exercise's landmark is missing, its target
// holds no solid, or a recording is empty; kUnavailable when `progress` ended it.
Result<MetricSet> ComputeMetrics(const scene::Scene& scene, const scene::Exercise& exercise,
                                 const AttemptData& attempt, const AttemptData& reference,
                                 const std::function<bool(double)>& progress = {},
                                 const MetricPlan& plan = MetricPlan::All());

}  // namespace enamel::scoring
