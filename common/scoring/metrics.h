#pragma once

#include <array>
#include <bitset>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/core/core.h"
#include "common/scene/types.h"
#include "common/surface/surface.h"
#include "common/trace/trace.h"

// What is measured about an attempt: schemas/score.md says of every metric the formula, unit and
// source; the tests have a worked example of each against a closed form.
//
// Deterministic: equal inputs give equal bits; only + - * / sqrt, fixed orders, no threads.
// Thread safety: functions, any thread; ProcessRecorder has one owner. Real-time: nothing here is.
namespace enamel::scoring {

// A metric's registry entry. A new metric is one function and one line in registry.cpp.
struct MetricInfo {
  std::string_view name;  // "wall_mesial_mm"
  std::string_view unit;  // "mm", "mm2", "mm3", "%", "N", "s"
  std::string_view title;
  std::string_view formula;  // one sentence for people
  // Signed metrics only: what a value above and below zero means ("too deep", "too shallow").
  std::string_view above_zero = {};
  std::string_view below_zero = {};
};
std::span<const MetricInfo> Metrics();
const MetricInfo* FindMetric(std::string_view name);  // nullptr when unknown

// A stretch of the recording reduced to what the alignment needs.
struct PathSample {
  double time_s;   // since the start, gaps included
  dvec3 anchor_m;  // scene frame, at the stretch's first tick
  dvec3 force_n;   // sent without touch cues, mean over the stretch
  double way_m;    // of the anchor until then, without the jumps after gaps and faults
};

// Accumulates process metrics during the replay pass (trace::Replay's observe). Pose and force are
// taken at the resolution of the witness (10 nm, 0.1 mN), so that a recording read back without
// re-running the core gives the same figures. The force is what the hand pressed with
// (core::PressedForce_100un): a touch cue is not the student's.
class ProcessRecorder {
 public:
  // Requires: ValidateParams(params).ok().
  explicit ProcessRecorder(const core::CoreParams& params);

  void Add(const trace::Tick& tick, const core::TickOutput& output);
  // The same from the recording alone, for a reference whose replay was verified before: everything
  // but what needs the removal (cutting_s, force_sent_mean_cutting_n stay 0).
  void AddRecorded(const trace::Tick& tick);

  // After the last Add:
  uint64_t ticks() const { return ticks_; }
  uint64_t gap_ticks() const { return gap_ticks_; }
  double duration_s() const;  // gaps included
  // Time less than 50 ms after something was removed: a cut is renewed when it would leave a mark,
  // after some way or some ticks, so that most ticks of a stroke remove nothing themselves, the more
  // of them the faster the loop. Recordings before core version 4: the ticks that removed something.
  double cutting_s() const;
  double anchor_path_m() const { return path_m_; }  // without the jumps after gaps and faults
  double force_sent_p95_n() const;                  // over ticks with any force; 1 mN steps
  double force_sent_max_n() const { return max_force_n_; }
  double force_sent_mean_cutting_n() const;  // mean over cutting ticks; 0 when nothing was cut
  uint64_t bounded_ticks() const { return bounded_ticks_; }  // peak bound engaged
  uint64_t late_ticks() const { return late_ticks_; }
  // At most 50 Hz.
  const std::vector<PathSample>& samples() const { return samples_; }

 private:
  void AddWitness(const core::TickInput& input, const core::TickWitness& witness, bool cutting);

  uint32_t rate_hz_;
  dvec3 origin_m_;
  uint32_t decimation_;  // ticks per kept sample
  uint64_t cutting_window_,
      cutting_left_ = 0;  // ticks that count as cutting after one that removed
  uint64_t cutting_time_ticks_ = 0;
  uint64_t ticks_ = 0, cutting_ticks_ = 0, bounded_ticks_ = 0, late_ticks_ = 0, gap_ticks_ = 0;
  uint64_t force_ticks_ = 0;
  double path_m_ = 0, max_force_n_ = 0, cutting_force_sum_n_ = 0;
  dvec3 last_anchor_{0};
  std::vector<uint32_t> force_histogram_;  // 1 mN bins
  std::vector<PathSample> samples_;
};

// Everything about one attempt (or reference) that metrics are computed from. Nothing is owned.
// All volumes of one comparison have the same grid.
struct AttemptData {
  const cutting::Volume* initial = nullptr;
  const cutting::Volume* final_volume = nullptr;
  const surface::Mesh* final_surface = nullptr;  // of final_volume
  const ProcessRecorder* process = nullptr;
  // Of the attempt only: DeviationPerVertex of final_surface where the caller has it already;
  // computed when null.
  const std::vector<float>* deviation_m = nullptr;
};

struct MetricValue {
  std::string name;
  double value = 0;
  std::string unit;

  bool operator==(const MetricValue&) const = default;
};

// Parts of the measurement that are done or left out as a whole.
enum class MetricGroup : uint8_t {
  kTask,        // what went, per tissue and against the task
  kDeviation,   // distances between the surfaces
  kRecording,   // time, force and way
  kZones,       // target, leeway, container
  kWalls,       // walls and floor: offset, tilt, waviness
  kOutline,     // on the tooth's surface
  kCover,       // of the pulp; depth in a neighbour
  kPathInTime,  // against the reference's path, by time
};
inline constexpr size_t kMetricGroups = 8;

// The groups that a list of metrics needs. A group is measured for all its metrics at the cost of
// one, so all of a group's are reported.
class MetricPlan {
 public:
  // Page, report and class lists show these of every attempt, whatever its rubric asks for: closeness
  // and its heat map, task, tissues, time and force.
  static constexpr std::array kBaseGroups = {MetricGroup::kTask, MetricGroup::kDeviation,
                                             MetricGroup::kRecording};

  static MetricPlan All();
  // The base and the groups of the rubric's criteria and gates. Metrics that do not exist are
  // ignored (ValidateRubric says so).
  static MetricPlan For(const scene::Rubric& rubric);

  void Add(MetricGroup group) { groups_.set(static_cast<size_t>(group)); }
  bool Has(MetricGroup group) const { return groups_.test(static_cast<size_t>(group)); }

 private:
  std::bitset<kMetricGroups> groups_;
};

// Why a metric has no value.
enum class NoValue {
  kNotInTask,  // this exercise does not ask for it: no caries in its task, no such wall
  kNotMade,    // it asks, and the attempt has not made what could be measured
  kNotUsed,    // the exercise's plan does not measure it; scoring by another rubric may
};
struct MissingMetric {
  std::string name;
  NoValue why = NoValue::kNotInTask;

  bool operator==(const MissingMetric&) const = default;
};

// Every metric of Metrics() is in one of the two lists, in its order.
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

// The plan's metrics of an attempt against a reference. `progress` (0..1) may be empty. Errors:
// kInvalidInput when grids differ, the exercise's landmark is missing, its target holds no solid, or
// a recording is empty.
Result<MetricSet> ComputeMetrics(const scene::Scene& scene, const scene::Exercise& exercise,
                                 const AttemptData& attempt, const AttemptData& reference,
                                 const std::function<void(double)>& progress = {},
                                 const MetricPlan& plan = MetricPlan::All());

}  // namespace enamel::scoring
