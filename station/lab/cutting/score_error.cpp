#include <algorithm>
#include <memory>

#include "common/scoring/metrics.h"
#include "common/scoring/score.h"
#include "common/surface/surface.h"
#include "common/trace/replay.h"
#include "station/lab/cutting/attempt.h"
#include "station/lab/cutting/cutting_error.h"

namespace enamel::station::lab {
namespace {

// A replayed attempt with scoring's inputs.
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
  ENAMEL_ASSIGN_OR_RETURN(auto attempt, RecordAttempt(options));
  Scored out;
  out.attempt = std::move(attempt);
  const core::CoreParams& params = out.attempt.header.params;
  out.core = std::make_unique<core::Core>(params, out.attempt.built.volume);
  out.process = std::make_unique<scoring::ProcessRecorder>(params);
  auto report = trace::Replay(*out.core, out.attempt.header, out.attempt.chunks,
                              [&](const trace::Tick& tick, const core::TickOutput& output) {
                                out.process->Add(tick, output);
                              });
  ENAMEL_RETURN_IF_ERROR(report.status());
  // As on the server: figures of a recording that does not replay would be meaningless.
  if (!report->witness_ok) return Status(Code::kConflict, "a replay disagrees with its recording");
  out.realtime_factor = static_cast<double>(report->ticks) / params.rate_hz / report->seconds;
  out.mesh = surface::ExtractSurface(out.core->volume());
  return out;
}

Result<ScoreFigures> MeasureAt(int32_t voxel_nm, uint64_t ticks) {
  AttemptOptions options;
  options.voxel_nm = voxel_nm;
  options.ticks = ticks;
  // At the same voxel size, so that the hands are compared and not the grids.
  ENAMEL_ASSIGN_OR_RETURN(auto reference, Cut(options));
  options.mesial_extra_m = kMesialExtra_m;
  options.floor_extra_m = kFloorExtra_m;
  ENAMEL_ASSIGN_OR_RETURN(auto student, Cut(options));
  const scene::BuiltScene& built = student.attempt.built;
  const scene::Exercise& exercise = student.attempt.exercise;
  ENAMEL_ASSIGN_OR_RETURN(
      auto metrics,
      scoring::ComputeMetrics(built.scene, exercise, student.Data(), reference.Data(), {}));
  const scoring::AcceptableCut r(built.volume, reference.core->volume(),
                                 {built.scene.tooth, built.scene.up});
  ENAMEL_ASSIGN_OR_RETURN(const auto judged,
                          scoring::JudgeCut(r, student.core->volume(), exercise.rubric));
  ENAMEL_ASSIGN_OR_RETURN(const auto score,
                          scoring::ApplyRubric(exercise.rubric, metrics, judged.measures));
  ScoreFigures out;
  out.voxel_nm = voxel_nm;
  out.mb = static_cast<double>(built.volume.MemoryBytes()) * 1e-6;
  out.realtime_factor = student.realtime_factor;
  out.points = score.score;
  for (size_t i = 0; i < r.regions().size(); ++i) {
    const scoring::RegionMeasure& m = judged.measures[i];
    out.regions.push_back({m.name, std::string(scoring::UnitOf(m.kind)), m.over, 0});
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
    ENAMEL_ASSIGN_OR_RETURN(auto figures, MeasureAt(voxel_nm, ticks));
    out.push_back(std::move(figures));
  }
  for (ScoreFigures& f : out) {
    for (RegionFigures& region : f.regions) {
      const auto finest =
          std::ranges::find(out.back().regions, region.region, &RegionFigures::region);
      region.error = finest == out.back().regions.end() ? 0 : region.over - finest->over;
    }
  }
  if (progress) progress("scores", voxels_nm.size(), voxels_nm.size());
  return out;
}

}  // namespace enamel::station::lab
