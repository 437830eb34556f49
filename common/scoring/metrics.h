#pragma once

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

// What is measured about an attempt. Every metric: formula, unit, source in metrics.cpp beside its
// code, a worked example in the tests against a closed form.
namespace enamel::scoring {

// A metric's registry entry: a new metric is one function and one line.
struct MetricInfo {
  std::string_view name;      // "wall_mesial_mm"
  std::string_view unit;      // "mm", "mm3", "%", "N", "s", "count"
  std::string_view title;
  std::string_view formula;   // one sentence for people
};
std::span<const MetricInfo> Metrics();
const MetricInfo* FindMetric(std::string_view name);

// One tick of the trace reduced to what process metrics need, at <= 50 Hz for alignment.
struct PathSample {
  double time_s;
  dvec3 anchor_m;
  dvec3 force_n;
};

// Accumulates process metrics during the replay pass (trace::Replay's observe).
// Thread safety: none.
class ProcessRecorder {
 public:
  explicit ProcessRecorder(uint32_t rate_hz);
  void Add(const trace::Tick& tick, const core::TickOutput& output);

  // After the last Add:
  uint64_t ticks() const { return ticks_; }
  double duration_s() const;
  double cutting_s() const;                    // ticks that removed something
  double anchor_path_m() const { return path_m_; }
  double force_sent_p95_n() const;
  double force_sent_max_n() const { return max_force_n_; }
  double force_sent_mean_cutting_n() const;    // mean over cutting ticks
  uint64_t bounded_ticks() const { return bounded_ticks_; }
  uint64_t late_ticks() const { return late_ticks_; }
  const std::vector<PathSample>& samples() const { return samples_; }

 private:
  uint32_t rate_hz_;
  uint32_t decimation_;                        // ticks per kept sample
  uint64_t ticks_ = 0, cutting_ticks_ = 0, bounded_ticks_ = 0, late_ticks_ = 0, gap_ticks_ = 0;
  double path_m_ = 0, max_force_n_ = 0, cutting_force_sum_n_ = 0;
  bool have_last_ = false;
  dvec3 last_anchor_{0};
  std::vector<uint32_t> force_histogram_;      // 1 mN bins
  std::vector<PathSample> samples_;
};

// Everything about one attempt (or reference) that metrics are computed from.
struct AttemptData {
  const cutting::Volume* initial = nullptr;
  const cutting::Volume* final_volume = nullptr;
  const surface::Mesh* final_surface = nullptr;
  const ProcessRecorder* process = nullptr;
};

struct MetricValue {
  std::string name;
  double value = 0;
  std::string unit;
};

// Signed deviation (m) of every vertex of `mesh` from the reference surface: positive where more was
// removed than in the reference, negative where less. NaN where the vertex belongs to the untouched
// initial surface in both (nothing was cut there and nothing should have been).
std::vector<float> DeviationPerVertex(const surface::Mesh& mesh, const cutting::Volume& initial,
                                      const cutting::Volume& final_volume,
                                      const cutting::Volume& reference,
                                      const surface::Mesh& reference_surface);

// All metrics of an attempt against a reference. `progress` may be empty.
Result<std::vector<MetricValue>> ComputeMetrics(const scene::Scene& scene, const scene::Exercise& exercise,
                                                const AttemptData& attempt, const AttemptData& reference,
                                                const std::function<void(double)>& progress = {});

}  // namespace enamel::scoring
