#include "server/jobs/reference_check.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "common/scene/json/json.h"
#include "common/scene/prepared_target.h"
#include "common/scoring/task.h"
#include "common/scoring/zones.h"
#include "server/jobs/regrade.h"
#include "server/jobs/stored_tooth.h"
#include "server/training/revision.h"

namespace enamel::server {
namespace {

constexpr double kMm3PerM3 = 1e9;

Status RefusedCut(const std::string& why) {
  return Status(Code::kConflict,
                "this attempt cannot be the reference: " + why +
                    "; choose another attempt, or give a reason why this one is right",
                std::string(kAnyway));
}

}  // namespace

Result<TargetWork> WorkOnTarget(const scene::Scene& scene, const scene::Exercise& exercise,
                                const cutting::Volume& initial,
                                const cutting::Volume& final_volume) {
  ENAMEL_ASSIGN_OR_RETURN(auto zones, scoring::BoxesOf(scene, exercise.target));
  scoring::GrowZones(initial, zones);
  const auto target = scoring::MeasureZone(initial, final_volume, zones, scoring::Zone::kTarget);
  const auto leeway = scoring::MeasureZone(initial, final_volume, zones, scoring::Zone::kLeeway);
  const double all_m3 = scoring::Sum_m3(scoring::RemovedPerTissue_m3(initial, final_volume));
  TargetWork out;
  out.target_mm3 = target.solid_m3 * kMm3PerM3;
  // Two sums of the same voxels in another order may differ in their last digits.
  const double beside_m3 = std::max(0.0, all_m3 - leeway.removed_m3);
  out.beside_mm3 = beside_m3 * kMm3PerM3;
  if (target.solid_m3 <= 0) return out;
  out.done_percent = 100 * target.removed_m3 / target.solid_m3;
  out.beside_percent = 100 * beside_m3 / target.solid_m3;
  return out;
}

Result<TargetWork> WorkOfAttempt(StoredBlobs& blobs, ResultRows& results,
                                 const AttemptRow& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(const auto text, blobs.GetBlob(attempt.exercise_content));
  ENAMEL_ASSIGN_OR_RETURN(auto exercise, scene::ExerciseFromJson(AsText(text)));
  ENAMEL_ASSIGN_OR_RETURN(const auto scene_text, blobs.GetBlob(exercise.scene));
  ENAMEL_ASSIGN_OR_RETURN(const auto scene, scene::SceneFromJson(AsText(scene_text)));
  ENAMEL_ASSIGN_OR_RETURN(const auto initial, StoredVolume(blobs, scene.volume));
  ENAMEL_ASSIGN_OR_RETURN(const auto result, results.ResultOf(attempt.id));
  ENAMEL_ASSIGN_OR_RETURN(const auto after, CutTooth(blobs, result.final_volume));
  ENAMEL_RETURN_IF_ERROR(scene::LoadPreparedTarget(
      initial, [&](const Sha256& hash) { return blobs.GetBlob(hash); }, exercise.target));
  return WorkOnTarget(scene, exercise, initial, after);
}

Status CheckReferenceCut(StoredBlobs& blobs, ResultRows& results, const AttemptRow& attempt) {
  if ((attempt.flags & kOverTime) != 0) {
    return RefusedCut("it took longer than the exercise's time limit");
  }
  if ((attempt.flags & kContradicted) != 0) {
    return RefusedCut("a second recording with other content was sent for it");
  }
  const auto score = StoredScore(blobs, results, attempt.id);
  if (!score.ok()) {
    return RefusedCut("its score cannot be read: " + score.status().message());
  }
  if (const scoring::Disturbance& d = score->disturbance; d.disturbed()) {
    return RefusedCut(
        fmt::format("the station or its device disturbed it: {:.1f} % of its ticks came "
                    "late, {:.1f} % of its time is missing, {:.1f} % was at the "
                    "device's limit",
                    d.late_percent, d.gap_percent, d.limited_percent));
  }
  const auto measured = WorkOfAttempt(blobs, results, attempt);
  if (!measured.ok()) {
    return RefusedCut("what it did of the exercise's own target cannot be measured: " +
                      measured.status().message());
  }
  const TargetWork& work = *measured;
  if (work.done_percent < kMinDone_percent) {
    return RefusedCut(
        fmt::format("expected at least {:.0f} % of the exercise's own target of {:.1f} "
                    "mm3 to be done, found {:.1f} %",
                    kMinDone_percent, work.target_mm3, work.done_percent));
  }
  if (work.beside_percent > kMaxBeside_percent) {
    return RefusedCut(
        fmt::format("expected at most {:.0f} % of the exercise's own target of {:.1f} "
                    "mm3 to be cut beside it and its leeway, found {:.1f} % ({:.1f} "
                    "mm3)",
                    kMaxBeside_percent, work.target_mm3, work.beside_percent, work.beside_mm3));
  }
  return Status::Ok();
}

Result<ReferenceRow> MakeReference(Store& store, const Uuid& attempt, const std::string& dentist,
                                   bool consent, const std::string& anyway, const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(const auto row, store.attempts.AttemptById(attempt));
  // An unscored attempt has nothing to check; the store reports that.
  if (anyway.empty() && row.state == AttemptState::kScored && row.expired_ms == 0) {
    ENAMEL_RETURN_IF_ERROR(CheckReferenceCut(store.blobs, store.results, row));
  }
  return store.references.AddReference(attempt, dentist, consent, by, anyway);
}

}  // namespace enamel::server
