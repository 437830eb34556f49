#include "server/jobs/rubric_check.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <set>

#include "common/scene/json/json.h"
#include "common/scene/prepared_target.h"
#include "common/scene/price_kinds.h"
#include "common/scene/volume_blob.h"
#include "common/scoring/metrics.h"
#include "common/scoring/trial.h"
#include "server/jobs/reference_cache.h"
#include "server/jobs/regrade.h"
#include "server/training/names.h"

namespace enamel::server {
namespace {

// A score is shown with one decimal.
constexpr double kFullMarks = 99.95;

Result<scene::Exercise> DocumentOf(StoredBlobs& blobs, const ExerciseRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(const auto text, blobs.GetBlob(row.content));
  return scene::ExerciseFromJson(AsText(text));
}

Result<cutting::Volume> ToothOf(StoredBlobs& blobs, const Sha256& hash) {
  ENAMEL_ASSIGN_OR_RETURN(const auto blob, blobs.GetBlob(hash));
  return scene::DecodeVolume(blob);
}

// The reference's metrics against itself, of the groups that `rubric` uses.
Result<scoring::MetricSet> MeasuredAgainstItself(Store& store, const ExerciseRow& row,
                                                 const Uuid& reference,
                                                 const scene::Rubric& rubric) {
  ENAMEL_ASSIGN_OR_RETURN(auto exercise, DocumentOf(store.blobs, row));
  ENAMEL_ASSIGN_OR_RETURN(const auto scene_text, store.blobs.GetBlob(exercise.scene));
  ENAMEL_ASSIGN_OR_RETURN(const auto scene, scene::SceneFromJson(AsText(scene_text)));
  ENAMEL_ASSIGN_OR_RETURN(const auto initial, ToothOf(store.blobs, scene.volume));
  ENAMEL_RETURN_IF_ERROR(scene::LoadPreparedTarget(
      initial, [&](const Sha256& hash) { return store.blobs.GetBlob(hash); }, exercise.target));
  ReferenceCache cache;
  ENAMEL_ASSIGN_OR_RETURN(const auto cut, cache.Get(store, reference));
  const scoring::AttemptData data{&initial, &cut->final_volume, &cut->surface, &cut->process};
  return scoring::ComputeMetrics(scene, exercise, data, data, {}, scoring::MetricPlan::For(rubric));
}

}  // namespace

Status CheckRubricWords(const scene::Rubric& rubric) {
  for (size_t i = 0; i < rubric.prices.size(); ++i) {
    const std::string place = "prices[" + std::to_string(i) + "].";
    ENAMEL_RETURN_IF_ERROR(CheckOneLine(rubric.prices[i].source, place + "source"));
  }
  for (size_t i = 0; i < rubric.criteria.size(); ++i) {
    const std::string place = "criteria[" + std::to_string(i) + "].";
    ENAMEL_RETURN_IF_ERROR(CheckOneLine(rubric.criteria[i].title, place + "title"));
    ENAMEL_RETURN_IF_ERROR(CheckOneLine(rubric.criteria[i].comment, place + "comment"));
  }
  return Status::Ok();
}

Status MustKeepRegions(const scene::Rubric& counting, const scene::Rubric& rubric) {
  for (const scene::RubricPrice& price : counting.prices) {
    const scene::PriceKind* kind = scene::FindPriceKind(price.of);
    if ((kind != nullptr && !kind->is_needed) ||
        std::ranges::find(rubric.prices, price.of, &scene::RubricPrice::of) != rubric.prices.end())
      continue;
    return Status(
        Code::kInvalidInput,
        "expected a price for \"" + price.of +
            "\", which the current rubric has, found none: work on it could not be scored",
        "prices");
  }
  return Status::Ok();
}

std::vector<std::string> RepeatedMetrics(const scene::Rubric& rubric) {
  std::vector<std::string> out;
  std::set<std::string> seen, told;
  for (const scene::RubricCriterion& criterion : rubric.criteria) {
    const std::string& metric = criterion.metric;
    if (seen.insert(metric).second || !told.insert(metric).second) continue;
    out.push_back(metric +
                  " is asked for by more than one criterion: what is found there costs more than "
                  "once");
  }
  return out;
}

Result<std::optional<std::string>> OtherOwnerOfRubric(Store& store, const ExerciseRow& exercise,
                                                      const scene::Rubric& counting,
                                                      const std::string& name) {
  std::optional<std::string> none;
  if (name == counting.name) return none;
  ENAMEL_ASSIGN_OR_RETURN(const auto rows, store.exercises.AllExercises());
  for (const ExerciseRow& row : rows) {
    if (row.name == exercise.name) continue;
    const auto document = DocumentOf(store.blobs, row);
    if (!document.ok()) continue;
    const auto theirs = CountingRubric(store.blobs, store.rubrics, row.id, document->rubric);
    if (theirs.ok() && theirs->name == name) return std::optional(row.name);
  }
  return none;
}

Result<std::optional<scoring::ScoreResult>> ReferenceUnder(Store& store,
                                                           const ExerciseRow& exercise,
                                                           const scene::Rubric& rubric,
                                                           bool stored_only) {
  std::optional<scoring::ScoreResult> none;
  ENAMEL_ASSIGN_OR_RETURN(const auto reference, store.references.ReferenceFor(exercise.id));
  if (!reference) return none;
  const auto stored = StoredScore(store.blobs, store.results, reference->attempt);
  const bool against_itself = stored.ok() && stored->reference_attempt == reference->attempt.Text();
  if (against_itself && stored->scoring_version == scoring::kScoringVersion) {
    auto score = scoring::ApplyRubric(rubric, {stored->metrics, stored->missing}, stored->measures);
    if (score.ok()) return std::optional(std::move(*score));
  }
  if (stored_only) return none;
  ENAMEL_ASSIGN_OR_RETURN(const auto metrics,
                          MeasuredAgainstItself(store, exercise, reference->attempt, rubric));
  ENAMEL_RETURN_IF_ERROR(scoring::CheckCriticalIsMeasured(rubric, metrics));
  // A cut has no fault beside itself, so that no region of it is measured: the hand alone can cost.
  ENAMEL_ASSIGN_OR_RETURN(auto score, scoring::ApplyRubric(rubric, metrics, {}));
  return std::optional(std::move(score));
}

std::string LostByReference(const scoring::ScoreResult& score) {
  if (score.score >= kFullMarks && !score.critical_fail) return {};
  std::string why;
  for (const scoring::LostItem& lost : scoring::LostItems(score)) {
    why += fmt::format("{} {} costs {:.1f}", why.empty() ? ":" : ",", lost.name, lost.points);
  }
  return fmt::format("the reference itself would get {:.1f} of 100{}{}", score.score,
                     score.critical_fail ? ", failed" : "", why);
}

Result<std::string> Objections(Store& store, const ExerciseRow& exercise,
                               const scene::Rubric& counting, const scene::Rubric& rubric,
                               bool stored_only) {
  ENAMEL_ASSIGN_OR_RETURN(const auto other,
                          OtherOwnerOfRubric(store, exercise, counting, rubric.name));
  std::string out;
  if (other) {
    out = "expected a correction of the rubric \"" + counting.name + "\", found \"" + rubric.name +
          "\", which is that of exercise \"" + *other + "\"";
  }
  const auto score = ReferenceUnder(store, exercise, rubric, stored_only);
  if (!score.ok() || !*score) return out;
  const std::string lost = LostByReference(**score);
  if (!lost.empty()) out += (out.empty() ? "expected full marks for the reference: " : "; ") + lost;
  return out;
}

}  // namespace enamel::server
