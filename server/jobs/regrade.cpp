#include "server/jobs/regrade.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "common/scene/json/json.h"
#include "server/jobs/rubric_check.h"
#include "server/training/names.h"
#include "server/training/revision.h"

namespace enamel::server {
namespace {

constexpr uint32_t kPage = 200;
constexpr double kRounding = 1e-9;  // a score document's numbers have twelve digits

// Whether an attempt was measured against other references than those that count now. A score that
// the exercise's own target gave names the references only where there were several.
bool MeasuredAgainstOthers(const scoring::ScoreResult& score,
                           const std::set<std::string>& counting) {
  if (counting.empty()) return false;
  if (!score.envelope) {
    const bool by_target = score.reference_attempt.empty();
    return counting.size() > 1 || (!by_target && !counting.contains(score.reference_attempt));
  }
  std::set<std::string> used;
  for (const scoring::EnvelopeOverlap& member : score.envelope->members)
    used.insert(member.attempt);
  return used != counting;
}

RegradedAttempt Regrade(StoredBlobs& blobs, ResultRows& results, const AttemptRow& row,
                        const scene::Rubric& rubric, const std::set<std::string>& counting) {
  RegradedAttempt out{row, row.score.value_or(0), 0, row.critical_fail, false, "", false};
  Result<scoring::ScoreResult> before = StoredScore(blobs, results, row.id);
  if (!before.ok()) {
    out.problem = before.status().message();
    return out;
  }
  out.other_references = MeasuredAgainstOthers(*before, counting);
  // A rubric judges numbers. Those of another version may mean something else under the same name.
  if (before->scoring_version != scoring::kScoringVersion) {
    out.problem = "measured by version " + std::to_string(before->scoring_version) +
                  " of the metrics, not by the current " +
                  std::to_string(scoring::kScoringVersion) + "; score it again";
    return out;
  }
  Result<scoring::ScoreResult> after =
      scoring::ApplyRubric(rubric, {before->metrics, before->missing}, before->measures);
  if (!after.ok()) {
    out.problem = after.status().message();
    return out;
  }
  out.after = after->score;
  out.failed_after = after->critical_fail;
  return out;
}

Result<scene::Rubric> CountingOf(StoredBlobs& blobs, RubricRows& rubrics,
                                 const ExerciseRow& exercise) {
  ENAMEL_ASSIGN_OR_RETURN(const auto text, blobs.GetBlob(exercise.content));
  ENAMEL_ASSIGN_OR_RETURN(const auto document, scene::ExerciseFromJson(AsText(text)));
  return CountingRubric(blobs, rubrics, exercise.id, document.rubric);
}

void Count(double score, ScoreHistogram& histogram) {
  const double tenth = std::clamp(std::floor(score / 10), 0.0, 9.0);
  ++histogram[static_cast<size_t>(tenth)];
}

}  // namespace

Result<scoring::ScoreResult> StoredScore(StoredBlobs& blobs, ResultRows& results,
                                         const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(auto result, results.ResultOf(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto text, blobs.GetBlob(result.score_json));
  return scoring::ScoreFromJson(AsText(text));
}

Result<scene::Rubric> CountingRubric(StoredBlobs& blobs, RubricRows& rubrics, const Uuid& exercise,
                                     const scene::Rubric& own) {
  ENAMEL_ASSIGN_OR_RETURN(auto row, rubrics.RubricFor(exercise));
  if (!row) return own;
  ENAMEL_ASSIGN_OR_RETURN(auto text, blobs.GetBlob(row->content));
  return scene::RubricFromJson(AsText(text));
}

Result<std::vector<AttemptRow>> ScoredAttempts(AttemptRows& attempts, AttemptFilter which) {
  which.state = AttemptState::kScored;
  which.limit = kPage;
  which.before.reset();
  std::vector<AttemptRow> out;
  while (out.size() < kMaxPreviewed) {
    ENAMEL_ASSIGN_OR_RETURN(auto page, attempts.Attempts(which));
    if (page.empty()) break;
    which.before = page.back().id;
    out.insert(out.end(), page.begin(), page.end());
  }
  return out;
}

std::vector<std::string> RubricWarnings(Store& store, const ExerciseRow& exercise,
                                        const scene::Rubric& rubric, bool quick) {
  std::vector<std::string> out = RepeatedMetrics(rubric);
  if (const auto counting = CountingOf(store.blobs, store.rubrics, exercise); counting.ok()) {
    const auto objections = Objections(store, exercise, *counting, rubric, quick);
    if (objections.ok() && !objections->empty()) out.push_back(*objections);
  }
  return out;
}

Result<RubricPreview> PreviewRubric(Store& store, const AttemptFilter& which,
                                    const scene::Rubric& rubric,
                                    const std::vector<ReferenceRow>& counting) {
  ENAMEL_RETURN_IF_ERROR(scoring::ValidateRubric(rubric));
  std::set<std::string> references;
  for (const ReferenceRow& row : counting) references.insert(row.attempt.Text());
  ENAMEL_ASSIGN_OR_RETURN(auto rows, ScoredAttempts(store.attempts, which));
  RubricPreview out;
  for (const AttemptRow& row : rows) {
    out.attempts.push_back(Regrade(store.blobs, store.results, row, rubric, references));
    const RegradedAttempt& a = out.attempts.back();
    out.other_references += a.other_references ? 1 : 0;
    if (!a.problem.empty()) {
      ++out.problems;
      continue;
    }
    Count(a.before, out.before);
    Count(a.after, out.after);
    out.raised += a.change() > 0 ? 1 : 0;
    out.lowered += a.change() < 0 ? 1 : 0;
    out.withdrawn += row.released && std::abs(a.after - a.before) > kRounding ? 1 : 0;
    out.mean_before += a.before;
    out.mean_after += a.after;
  }
  if (const size_t told = out.attempts.size() - out.problems; told > 0) {
    out.mean_before /= static_cast<double>(told);
    out.mean_after /= static_cast<double>(told);
  }
  std::ranges::stable_sort(out.attempts, std::ranges::greater{}, [](const RegradedAttempt& a) {
    return a.problem.empty() ? std::abs(a.change()) : 0;
  });
  return out;
}

Result<RubricRow> PublishCorrection(Store& store, const Uuid& exercise, scene::Rubric rubric,
                                    int32_t seen, const std::string& reason,
                                    const std::string& anyway, const Actor& by) {
  ENAMEL_RETURN_IF_ERROR(scoring::ValidateRubric(rubric));
  ENAMEL_RETURN_IF_ERROR(CheckRubricWords(rubric));
  ENAMEL_ASSIGN_OR_RETURN(std::string why, CheckedReason(reason, "reason"));
  ENAMEL_ASSIGN_OR_RETURN(auto row, store.exercises.ExerciseById(exercise));
  ENAMEL_ASSIGN_OR_RETURN(auto counting, CountingOf(store.blobs, store.rubrics, row));
  ENAMEL_RETURN_IF_ERROR(MustKeepRegions(counting, rubric));
  // Two corrections at once: the second has not seen the first, and would undo it.
  if (counting.version != seen) {
    return Status(Code::kConflict,
                  "the current rubric has version " + std::to_string(counting.version) +
                      ", the correction is based on version " + std::to_string(seen) +
                      "; look at it and try again",
                  std::string(kStale));
  }
  rubric.version = counting.version;
  if (rubric == counting) {
    return Status(Code::kConflict, "the current rubric is already the same");
  }
  if (anyway.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(const auto objections, Objections(store, row, counting, rubric, false));
    if (!objections.empty()) {
      return Status(Code::kConflict,
                    objections + "; correct the rubric, or give a reason why it is right",
                    std::string(kAnyway));
    }
  } else {
    ENAMEL_ASSIGN_OR_RETURN(const auto insists, CheckedReason(anyway, "anyway"));
    why += " (anyway: " + insists + ")";
  }
  rubric.version = counting.version + 1;
  ENAMEL_ASSIGN_OR_RETURN(auto content, store.blobs.PutBlob(AsBytes(scene::ToJson(rubric))));
  return store.rubrics.PublishRubric({exercise, rubric.version, content, why, 0}, by);
}

}  // namespace enamel::server
