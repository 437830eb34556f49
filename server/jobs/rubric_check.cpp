#include "server/jobs/rubric_check.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <set>

#include "common/scene/json/json.h"
#include "common/scene/prepared_target.h"
#include "common/scene/volume_blob.h"
#include "common/scoring/metrics.h"
#include "server/jobs/reference_cache.h"
#include "server/jobs/regrade.h"
#include "server/training/names.h"

namespace enamel::server {
namespace {

// A score is shown with one decimal.
constexpr double kFullMarks = 99.95;

template <typename T>
Status CheckItems(const std::vector<T>& items, const std::string& list) {
  for (size_t i = 0; i < items.size(); ++i) {
    const std::string place = list + "[" + std::to_string(i) + "].";
    ENAMEL_RETURN_IF_ERROR(CheckOneLine(items[i].title, place + "title"));
    ENAMEL_RETURN_IF_ERROR(CheckOneLine(items[i].comment, place + "comment"));
  }
  return Status::Ok();
}

template <typename T>
void AddRepeated(const std::vector<T>& items, const char* what, std::vector<std::string>& out) {
  std::set<std::string> seen, told;
  for (const T& item : items) {
    if (seen.insert(item.metric).second || !told.insert(item.metric).second) continue;
    out.push_back(item.metric + " is asked for by more than one " + what +
                  ": what is found there costs more than once");
  }
}

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
  ENAMEL_RETURN_IF_ERROR(CheckItems(rubric.criteria, "criteria"));
  return CheckItems(rubric.gates, "gates");
}

std::vector<std::string> RepeatedMetrics(const scene::Rubric& rubric) {
  std::vector<std::string> out;
  AddRepeated(rubric.criteria, "criterion", out);
  AddRepeated(rubric.gates, "gate", out);
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
  const bool against_itself =
      stored.ok() &&
      (stored->reference_attempt.empty() || stored->reference_attempt == reference->attempt.Text());
  if (against_itself && stored->scoring_version == scoring::kScoringVersion) {
    auto score = scoring::ApplyRubric(rubric, {stored->metrics, stored->missing, {}});
    if (score.ok()) return std::optional(std::move(*score));
  }
  if (stored_only) return none;
  ENAMEL_ASSIGN_OR_RETURN(const auto metrics,
                          MeasuredAgainstItself(store, exercise, reference->attempt, rubric));
  ENAMEL_RETURN_IF_ERROR(scoring::CheckCriticalIsMeasured(rubric, metrics));
  ENAMEL_ASSIGN_OR_RETURN(auto score, scoring::ApplyRubric(rubric, metrics));
  return std::optional(std::move(score));
}

std::string LostByReference(const scoring::ScoreResult& score) {
  if (score.score >= kFullMarks && !score.critical_fail) return {};
  std::string why;
  auto add = [&why](const std::string& text) { why += (why.empty() ? "" : ", ") + text; };
  for (const scoring::GateResult& gate : score.gates) {
    if (gate.share < 1) {
      add(fmt::format("gate {} ({}) leaves {:.1f} % at {:.3g} {}", gate.title, gate.name,
                      100 * gate.share, gate.value, gate.unit));
    }
  }
  double share = 1;
  for (const scoring::GateResult& gate : score.gates) share *= gate.share;
  for (const scoring::CriterionResult& c : score.criteria) {
    if (c.judged && c.points < c.max_points * share - 1e-6) {
      add(fmt::format("{} ({}) {:.1f} of {:.1f}", c.title, c.name, c.points, c.max_points));
    }
  }
  return fmt::format("the reference itself would get {:.1f} of 100{}{}{}", score.score,
                     score.critical_fail ? ", failed" : "", why.empty() ? "" : ": ", why);
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
