#include <memory>

#include "common/measure/attempt.h"
#include "common/measure/cutting_error.h"
#include "common/scoring/metrics.h"
#include "common/scoring/score.h"
#include "common/surface/surface.h"
#include "common/trace/replay.h"

namespace enamel::measure {
namespace {

// An attempt replayed, with what scoring reads of it.
struct Scored {
  Attempt attempt;
  std::unique_ptr<core::Core> core;
  std::unique_ptr<scoring::ProcessRecorder> process;
  surface::Mesh mesh;
  double realtime_factor = 0;

  scoring::AttemptData Data() const {
    return {&attempt.built.volume, &core->volume(), &mesh, process.get(), nullptr};
  }
};

Result<Scored> Cut(const AttemptOptions& options) {
  auto attempt = RecordAttempt(options);
  if (!attempt.ok()) return attempt.status();
  Scored out;
  out.attempt = std::move(*attempt);
  const core::CoreParams& params = out.attempt.header.params;
  out.core = std::make_unique<core::Core>(params, out.attempt.built.volume);
  out.process = std::make_unique<scoring::ProcessRecorder>(params);
  auto report = trace::Replay(*out.core, out.attempt.header, out.attempt.chunks,
                              [&](const trace::Tick& tick, const core::TickOutput& output) {
                                out.process->Add(tick, output);
                              });
  if (!report.ok()) return report.status();
  if (!report->witness_ok) return Status(Code::kConflict, "a replay disagrees with its recording");
  out.realtime_factor = static_cast<double>(report->ticks) / params.rate_hz / report->seconds;
  out.mesh = surface::ExtractSurface(out.core->volume());
  return out;
}

Result<ScoreFigures> MeasureAt(int32_t voxel_nm, uint64_t ticks) {
  AttemptOptions options;
  options.voxel_nm = voxel_nm;
  options.ticks = ticks;
  auto reference = Cut(options);
  if (!reference.ok()) return reference.status();
  options.mesial_extra_m = kMesialExtra_m;
  options.floor_extra_m = kFloorExtra_m;
  auto student = Cut(options);
  if (!student.ok()) return student.status();
  const scene::BuiltScene& built = student->attempt.built;
  const scene::Exercise& exercise = student->attempt.exercise;
  auto metrics =
      scoring::ComputeMetrics(built.scene, exercise, student->Data(), reference->Data(), {});
  if (!metrics.ok()) return metrics.status();
  auto score = scoring::ApplyRubric(exercise.rubric, *metrics);
  if (!score.ok()) return score.status();
  ScoreFigures out;
  out.voxel_nm = voxel_nm;
  out.mb = static_cast<double>(built.volume.MemoryBytes()) * 1e-6;
  out.realtime_factor = student->realtime_factor;
  out.points = score->score;
  for (const scene::RubricCriterion& c : exercise.rubric.criteria) {
    for (const scoring::MetricValue& m : *metrics) {
      if (m.name == c.metric) out.criteria.push_back({m.name, m.unit, m.value, 0});
    }
  }
  return out;
}

}  // namespace

Result<std::vector<ScoreFigures>> MeasureScores(
    const std::vector<int32_t>& voxels_nm, uint64_t ticks,
    const std::function<void(const std::string&, size_t, size_t)>& progress) {
  std::vector<ScoreFigures> out;
  for (int32_t voxel_nm : voxels_nm) {
    if (progress) {
      progress("scores at " + std::to_string(voxel_nm / 1000) + " um", out.size(),
               voxels_nm.size());
    }
    auto figures = MeasureAt(voxel_nm, ticks);
    if (!figures.ok()) return figures.status();
    out.push_back(std::move(*figures));
  }
  for (ScoreFigures& f : out) {
    for (size_t i = 0; i < f.criteria.size(); ++i) {
      f.criteria[i].error = f.criteria[i].value - out.back().criteria[i].value;
    }
  }
  if (progress) progress("scores", voxels_nm.size(), voxels_nm.size());
  return out;
}

}  // namespace enamel::measure
