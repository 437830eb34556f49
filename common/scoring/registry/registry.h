#pragma once

#include <optional>
#include <span>

#include "common/scoring/measured.h"

// The list of metrics, in parts of one subject each. Private to registry*.cpp.
namespace enamel::scoring {

inline constexpr double kMm = 1e3, kMm2 = 1e6, kMm3 = 1e9;

inline double Percent(double part, double whole) { return whole > 0 ? 100 * part / whole : 0; }
inline double Of(const TissueVolumes_m3& v, cutting::Tissue t) { return v[static_cast<size_t>(t)]; }
inline double Removed(const Measured& m, cutting::Tissue t) { return Of(m.removed, t) * kMm3; }

// Whether a metric has a value here.
using State = std::optional<NoValue>;
inline State Always(const Measured&) { return {}; }
inline State Unless(bool in_task) { return in_task ? State{} : NoValue::kNotInTask; }
inline State IfMade(const std::optional<double>& value) {
  return value ? State{} : NoValue::kNotMade;
}
template <auto kFigures>
State WithMade(const Measured& m) {
  if (!(m.*kFigures).in_task) return NoValue::kNotInTask;
  return (m.*kFigures).made ? State{} : NoValue::kNotMade;
}

using enum MetricGroup;
using AtLimit = MetricInfo::AtLimit;

// A table and not a switch: what is measured, shown and named in a rubric is the same list.
struct Entry {
  MetricGroup group;
  MetricInfo info;
  double (*value)(const Measured&);
  State (*state)(const Measured&) = Always;
};

// In the order of Metrics(). Formulas in full, with sources: schemas/score.md.
std::span<const Entry> SurfaceMetrics();    // surface.cpp: boxes, distances, walls, outline
std::span<const Entry> CrownMetrics();      // crown.cpp: crown, line angles, margin
std::span<const Entry> TaskMetrics();       // task.cpp: what went and what is covered
std::span<const Entry> RecordingMetrics();  // recording.cpp: time, force, way, motion

}  // namespace enamel::scoring
