#include <algorithm>
#include <boost/json.hpp>

#include "common/scene/json/json.h"
#include "common/scoring/metrics.h"
#include "common/scoring/score.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/http/handlers/seen_attempt.h"
#include "server/http/handlers/seen_exercise.h"
#include "server/http/handlers/seen_teaching.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/query.h"
#include "server/jobs/regrade.h"
#include "server/training/access.h"
#include "server/training/names.h"
#include "server/training/revision.h"

// Correcting the rubric of an exercise that is published, and scoring a cohort again.
namespace enamel::server::http {
namespace json = boost::json;
namespace {

// Body, rubric, criteria, one of them, its map, a row of it.
constexpr size_t kRubricDepth = 6;

Result<scene::Exercise> DocumentOf(StoredBlobs& blobs, const ExerciseRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, blobs.GetBlob(row.content));
  return scene::ExerciseFromJson(AsText(bytes));
}

json::object VersionJson(const scene::Rubric& rubric, const std::string& reason,
                         UnixMs published_ms) {
  return {{"version", rubric.version},
          {"reason", reason},
          {"published_ms", published_ms},
          {"document", json::parse(scene::ToJson(rubric))}};
}

Result<json::object> VersionJson(StoredBlobs& blobs, const RubricRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(auto text, blobs.GetBlob(row.content));
  ENAMEL_ASSIGN_OR_RETURN(auto rubric, scene::RubricFromJson(AsText(text)));
  return VersionJson(rubric, row.reason, row.published_ms);
}

// Newest first, the exercise's own last.
Result<json::array> Versions(StoredBlobs& blobs, RubricRows& rubrics, const ExerciseRow& exercise) {
  ENAMEL_ASSIGN_OR_RETURN(auto rows, rubrics.Rubrics(exercise.id));
  json::array out;
  for (const RubricRow& row : rows) {
    ENAMEL_ASSIGN_OR_RETURN(auto version, VersionJson(blobs, row));
    out.push_back(std::move(version));
  }
  ENAMEL_ASSIGN_OR_RETURN(auto document, DocumentOf(blobs, exercise));
  out.push_back(VersionJson(document.rubric, "", exercise.published_ms));
  return out;
}

// A rubric of a newer format is the sender's mistake, not this server's.
Result<scene::Rubric> RubricOf(const std::string& text, const std::string& member) {
  Result<scene::Rubric> rubric = scene::RubricFromJson(text);
  if (rubric.ok()) return rubric;
  const Status& why = rubric.status();
  const Code code = why.code() == Code::kVersion ? Code::kInvalidInput : why.code();
  return Status{code, why.message(), member + why.field()};
}

// While somebody types: only whether the rubric is right.
Result<RubricPreview> PreviewOfNone(const scene::Rubric& rubric) {
  ENAMEL_RETURN_IF_ERROR(scoring::ValidateRubric(rubric));
  return RubricPreview();
}

json::array HistogramJson(const ScoreHistogram& histogram) {
  json::array out;
  for (uint32_t count : histogram) out.push_back(count);
  return out;
}

json::object PreviewJson(const RubricPreview& preview) {
  json::array attempts;
  for (const RegradedAttempt& a : preview.attempts) {
    json::value after, failed;
    if (a.problem.empty()) {
      after = a.after;
      failed = a.failed_after;
    }
    attempts.push_back(
        {{"attempt_id", a.row.id.Text()},
         {"person", {{"id", a.row.person.Text()}, {"display_name", a.row.person_name}}},
         {"before", a.before},
         {"after", std::move(after)},
         {"failed_before", a.failed_before},
         {"failed_after", std::move(failed)},
         {"overridden", a.row.overridden.has_value()},
         {"released", a.row.released},
         {"other_references", a.other_references},
         {"problem", a.problem}});
  }
  return {{"attempts", std::move(attempts)},
          {"raised", preview.raised},
          {"lowered", preview.lowered},
          {"problems", preview.problems},
          {"other_references", preview.other_references},
          {"withdrawn", preview.withdrawn},
          {"mean_before", preview.mean_before},
          {"mean_after", preview.mean_after},
          {"histogram_before", HistogramJson(preview.before)},
          {"histogram_after", HistogramJson(preview.after)}};
}

json::object BatchJson(const BatchRow& row) {
  json::value cohort;
  if (row.cohort) cohort = row.cohort->Text();
  return {{"id", row.id.Text()},        {"title", row.title},         {"cause", row.cause},
          {"cohort_id", cohort},        {"queued_ms", row.queued_ms}, {"queued", row.queued},
          {"running", row.running},     {"done", row.done},           {"failed", row.failed},
          {"cancelled", row.cancelled}, {"over", row.over()}};
}

bool Teaches(const std::vector<Cohort>& taught, const std::optional<Uuid>& cohort) {
  return cohort && std::ranges::find(taught, *cohort, &Cohort::id) != taught.end();
}

Result<BatchRow> SeenBatch(const Call& call, BatchRows& batches, CohortRows& cohorts) {
  Status none{Code::kNotFound, "there is no such batch", "id"};
  Result<BatchRow> row = batches.BatchById(call.id);
  if (!row.ok()) return row.status().code() == Code::kNotFound ? none : row.status();
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Cohort> taught, VisibleCohorts(call, cohorts));
  if (Teaches(taught, row->cohort)) return row;
  return none;
}

}  // namespace

Result<Response> ListScoringMetrics(const Call&, Store&) {
  json::array out;
  for (const scoring::MetricInfo& metric : scoring::Metrics()) {
    out.push_back({{"name", metric.name},
                   {"unit", metric.unit},
                   {"title", metric.title},
                   {"formula", metric.formula},
                   {"hand", !scoring::IsSeenOnTheTooth(metric.name)}});
  }
  return JsonResponse({{"metrics", std::move(out)}});
}

Result<Response> ListRubrics(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row, VisibleExercise(call, store.attempts, store.exercises));
  Result<json::array> versions = Versions(store.blobs, store.rubrics, row);
  // Stored rubrics were checked on arrival: an unreadable one is damage of ours.
  if (!versions.ok()) return Status(Code::kInternal, versions.status().message());
  const auto newest = static_cast<int32_t>(versions->front().at("version").as_int64());
  return WithETag(JsonResponse({{"rubrics", std::move(*versions)}}), newest);
}

Result<Response> PreviewRubricChange(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row, VisibleExercise(call, store.attempts, store.exercises));
  ENAMEL_ASSIGN_OR_RETURN(scene::Rubric rubric, RubricOf(call.request.body, ""));
  ENAMEL_ASSIGN_OR_RETURN(std::optional<bool> attempts, QueryFlag(call.request, "attempts"));
  AttemptFilter which;
  which.exercise = row.id;
  NarrowToTaught(call, which);
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ReferenceRow> counting, store.references.Counting(row.id));
  ENAMEL_ASSIGN_OR_RETURN(RubricPreview preview, attempts.value_or(true)
                                                     ? PreviewRubric(store, which, rubric, counting)
                                                     : PreviewOfNone(rubric));
  json::object out = PreviewJson(preview);
  out["warnings"] = json::value_from(RubricWarnings(store, row, rubric, !attempts.value_or(true)));
  return JsonResponse(out);
}

Result<Response> PublishRubric(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(ExerciseRow row,
                          ChangeableExercise(call, store.attempts, store.exercises));
  BodyReader body(call.request, kRubricDepth);
  const std::string reason = body.Text("reason", 1, kMaxReasonBytes);
  const std::string document = body.Document("rubric");
  std::string anyway;
  if (body.Has("anyway")) anyway = body.Text("anyway", 1, kMaxReasonBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_ASSIGN_OR_RETURN(scene::Rubric rubric, RubricOf(document, "rubric"));
  ENAMEL_ASSIGN_OR_RETURN(int32_t seen, IfMatch(call.request));
  Result<RubricRow> published =
      PublishCorrection(store, row.id, std::move(rubric), seen, reason, anyway, ActorOf(call));
  if (published.ok()) {
    // Its own row and not the newest: somebody may have corrected it again already.
    Result<json::object> version = VersionJson(store.blobs, *published);
    if (!version.ok()) return Status(Code::kInternal, version.status().message());
    return WithETag(JsonResponse(*version, 201), published->version);
  }
  if (published.status().field() != kStale) return published.status();
  Result<json::array> versions = Versions(store.blobs, store.rubrics, row);
  if (!versions.ok()) return Status(Code::kInternal, versions.status().message());
  const json::object newest = versions->front().as_object();
  return Stale(published.status(), newest, static_cast<int32_t>(newest.at("version").as_int64()));
}

Result<Response> RescoreCohort(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Cohort> taught, VisibleCohorts(call, store.cohorts));
  auto cohort = std::ranges::find(taught, call.id, &Cohort::id);
  if (cohort == taught.end()) {
    return Status(Code::kNotFound, "there is no such cohort", "id");
  }
  BodyReader body(call.request);
  AttemptFilter which;
  which.cohort = call.id;
  which.exercise = body.MaybeId("exercise_id");
  NarrowToTaught(call, which);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  BatchRow wanted;
  wanted.title = cohort->name;
  wanted.cause = "rubric";
  wanted.cohort = call.id;
  if (which.exercise) {
    Result<ExerciseRow> exercise = store.exercises.ExerciseById(*which.exercise);
    if (!exercise.ok()) {
      return Status(Code::kInvalidInput, "there is no such exercise", "exercise_id");
    }
    wanted.title += ", " + exercise->title;
  }
  ENAMEL_ASSIGN_OR_RETURN(std::vector<AttemptRow> rows, ScoredAttempts(store.attempts, which));
  std::vector<Uuid> attempts;
  for (const AttemptRow& row : rows) attempts.push_back(row.id);
  uint32_t left_out = 0;
  ENAMEL_ASSIGN_OR_RETURN(BatchRow batch,
                          store.batches.RescoreTogether(wanted, attempts, left_out, ActorOf(call)));
  json::object out = BatchJson(batch);
  out["left_out"] = left_out;
  return JsonResponse(out, 202);
}

Result<Response> ListBatches(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(std::vector<Cohort> taught, VisibleCohorts(call, store.cohorts));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<BatchRow> rows, store.batches.Batches());
  json::array batches;
  for (const BatchRow& row : rows) {
    if (Teaches(taught, row.cohort)) batches.push_back(BatchJson(row));
  }
  return JsonResponse({{"batches", std::move(batches)}});
}

Result<Response> GetBatch(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(BatchRow row, SeenBatch(call, store.batches, store.cohorts));
  return JsonResponse(BatchJson(row));
}

Result<Response> CancelBatch(const Call& call, Store& store) {
  Result<BatchRow> row = SeenBatch(call, store.batches, store.cohorts);
  ENAMEL_RETURN_IF_ERROR(row.status());
  if (Status done = store.batches.CancelBatch(call.id, ActorOf(call)); !done.ok()) {
    return done;
  }
  row = SeenBatch(call, store.batches, store.cohorts);
  ENAMEL_RETURN_IF_ERROR(row.status());
  return JsonResponse(BatchJson(*row));
}

}  // namespace enamel::server::http
