#include <boost/json.hpp>

#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/http/handlers/seen_attempt.h"
#include "server/http/json_body.h"
#include "server/http/kept.h"
#include "server/http/operations.h"
#include "server/http/paging.h"
#include "server/http/views/attempt_view.h"
#include "server/training/access.h"
#include "server/training/names.h"
#include "server/training/revision.h"

// What instructors and students say about an attempt, and scoring it again.
namespace enamel::server::http {
namespace json = boost::json;
namespace {

// Thirty years at 1 kHz, and exact in the doubles of a browser.
constexpr int64_t kMaxTick = int64_t{1} << 40;
constexpr int64_t kMaxRun = 1'000'000'000;

// The changed attempt.
Result<Response> AttemptResponse(const Call& call, Store& store, const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(AttemptRow row, store.attempts.AttemptById(attempt));
  AttemptView view(store, call.caller->person);
  ENAMEL_ASSIGN_OR_RETURN(json::object out, view.DetailJson(row));
  return WithETag(JsonResponse(out), row.revision);
}

Result<Response> JudgedOr(const Call& call, Store& store, const Status& status) {
  // With the changed attempt: the page needs its new revision for the next change.
  return status.ok() ? AttemptResponse(call, store, call.id) : JudgedMeanwhile(call, store, status);
}

json::object AnnotationJson(const Call& call, const AnnotationRow& row) {
  json::value point;
  if (row.point_um) {
    point = json::array{(*row.point_um)[0], (*row.point_um)[1], (*row.point_um)[2]};
  }
  return {{"id", row.id.Text()},
          {"attempt_id", row.attempt.Text()},
          {"author", {{"id", row.author.Text()}, {"display_name", row.author_name}}},
          {"tick", row.tick},
          {"point_um", std::move(point)},
          {"text", row.text},
          {"to_chair", row.to_chair},
          {"created_ms", row.created_ms},
          {"edited_ms", row.edited_ms},
          {"mine", row.author == call.caller->person.id},
          {"revision", row.revision}};
}

Result<AnnotationRow> RemarkIn(const Call& call) {
  BodyReader body(call.request);
  AnnotationRow row;
  row.tick = static_cast<uint64_t>(body.Integer("tick", 0, kMaxTick));
  row.point_um = body.MaybePoint("point_um");
  row.text = body.Text("text", 1, kMaxRemarkBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  return row;
}

// An annotation that the caller may change.
Result<AnnotationRow> OwnAnnotation(const Call& call, Store& store) {
  Status none{Code::kNotFound, "there is no such annotation", "id"};
  Result<AnnotationRow> row = store.remarks.AnnotationById(call.id);
  if (!row.ok()) return row.status().code() == Code::kNotFound ? none : row.status();
  Result<SeenAttempt> seen = SeeAttempt(call, store, row->attempt);
  // Of an attempt that the caller may not see: the remark counts as missing.
  if (!seen.ok()) return seen.status().code() == Code::kNotFound ? none : seen.status();
  const Person& viewer = call.caller->person;
  bool reviews = CanReviewAttempt(viewer, seen->row, seen->teaches);
  if (CanEditAnnotation(viewer, *row, reviews)) return row;
  return Status{Code::kForbidden,
                "only its author may change a remark; write one of your own instead"};
}

// Why a change of an annotation did not happen.
Result<Response> Refused(const Call& call, RemarkRows& remarks, const Status& status) {
  if (status.field() != kStale) return status;
  ENAMEL_ASSIGN_OR_RETURN(AnnotationRow now, remarks.AnnotationById(call.id));
  return Stale(status, AnnotationJson(call, now), now.revision);
}

}  // namespace

Result<Response> WithdrawRelease(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, ReviewAttempt(call, store, call.id));
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, IfMatch(call.request));
  Status done = store.judging.WithdrawRelease(call.id, ActorOf(call), revision);
  if (done.ok()) return Done();
  return JudgedMeanwhile(call, store, done);
}

Result<Response> PutOverride(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, ReviewAttempt(call, store, call.id));
  BodyReader body(call.request);
  ScoreOverride score;
  score.score = body.Number("score", 0, 100);
  score.reason = body.Text("reason", 1, kMaxReasonBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, IfMatch(call.request));
  return JudgedOr(call, store,
                  store.judging.OverrideScore(call.id, score, ActorOf(call), revision));
}

Result<Response> DeleteOverride(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, ReviewAttempt(call, store, call.id));
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, IfMatch(call.request));
  return JudgedOr(call, store,
                  store.judging.OverrideScore(call.id, std::nullopt, ActorOf(call), revision));
}

Result<Response> Rescore(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, ReviewAttempt(call, store, call.id));
  // No If-Match: it changes no judgement, and asking twice makes one more result, which is kept
  // with the others.
  ENAMEL_RETURN_IF_ERROR(store.judging.Rescore(call.id, "rescore", ActorOf(call)));
  ENAMEL_ASSIGN_OR_RETURN(Response response, AttemptResponse(call, store, call.id));
  response.status = 202;  // accepted: the job is in the queue and the score unchanged
  return response;
}

Result<Response> Excuse(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, ReviewAttempt(call, store, call.id));
  BodyReader body(call.request);
  std::string reason = body.Text("reason", 1, kMaxReasonBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, IfMatch(call.request));
  return JudgedOr(call, store,
                  store.judging.FlagAttempt(call.id, kExcused, reason, ActorOf(call), revision));
}

Result<Response> TakeExcuseBack(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, ReviewAttempt(call, store, call.id));
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, IfMatch(call.request));
  return JudgedOr(call, store, store.judging.ClearExcuse(call.id, ActorOf(call), revision));
}

Result<Response> RestoreResult(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, ReviewAttempt(call, store, call.id));
  BodyReader body(call.request);
  const auto run = static_cast<int32_t>(body.Integer("run", 1, kMaxRun));
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, IfMatch(call.request));
  return JudgedOr(call, store, store.results.RestoreResult(call.id, run, ActorOf(call), revision));
}

Result<Response> ListResults(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, SeeAttempt(call, store, call.id));
  if (!CanSeeScore(call.caller->person, seen.row, seen.graded, seen.teaches)) {
    return Status(Code::kForbidden,
                  "this work is graded: the results show after the instructor has released it");
  }
  if (Status hidden = ScoreMustNotBeHidden(call, store, call.id); !hidden.ok()) {
    return hidden;
  }
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kMaxPage, kMaxPage));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<ResultRow> rows, store.results.ResultsOf(call.id));
  const int32_t newest = rows.empty() ? 0 : rows.front().run;
  json::value next = CutPage(
      rows, page, [](const ResultRow& row) { return FallingKey(static_cast<uint64_t>(row.run)); });
  json::array results;
  for (const ResultRow& row : rows) {
    json::value reference;
    if (row.reference) reference = row.reference->Text();
    Result<Bytes> text = store.blobs.GetBlob(row.score_json);
    if (!text.ok()) return Status(Code::kInternal, text.status().message());
    json::error_code error;
    // Parsed and put in as JSON, so that a damaged document is found here and not by the page.
    json::value score = json::parse(AsText(*text), error);
    if (error) return Status(Code::kInternal, "stored score is no JSON");
    results.push_back(
        {{"run", row.run},
         {"scored_ms", row.scored_ms},
         {"cause", row.cause},
         {"restorable", row.is_whole && row.run != newest && seen.row.expired_ms == 0},
         {"reference_attempt", std::move(reference)},
         {"replay_realtime_factor", row.replay_realtime_factor},
         {"score", std::move(score)}});
  }
  return Packed(call.request,
                JsonResponse({{"results", std::move(results)}, {"next", std::move(next)}}));
}

Result<Response> ListAnnotations(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, SeeAttempt(call, store, call.id));
  if (!CanSeeScore(call.caller->person, seen.row, seen.graded, seen.teaches)) {
    return Status(Code::kForbidden,
                  "this work is graded: remarks show after the instructor has released it");
  }
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, kMaxPage, kMaxPage));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<AnnotationRow> rows, store.remarks.AnnotationsOf(call.id));
  json::value next = CutPage(
      rows, page, [](const AnnotationRow& row) { return RisingKey(row.tick) + row.id.Text(); });
  json::array annotations;
  for (const AnnotationRow& row : rows) annotations.push_back(AnnotationJson(call, row));
  return JsonResponse({{"annotations", std::move(annotations)}, {"next", std::move(next)}});
}

Result<Response> AddAnnotation(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, ReviewAttempt(call, store, call.id));
  ENAMEL_ASSIGN_OR_RETURN(AnnotationRow remark, RemarkIn(call));
  remark.attempt = call.id;
  ENAMEL_ASSIGN_OR_RETURN(AnnotationRow row, store.remarks.AddAnnotation(remark, ActorOf(call)));
  return WithETag(JsonResponse(AnnotationJson(call, row), 201), row.revision);
}

Result<Response> ReplaceAnnotation(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(AnnotationRow stored, OwnAnnotation(call, store));
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, IfMatch(call.request));
  ENAMEL_ASSIGN_OR_RETURN(AnnotationRow remark, RemarkIn(call));
  remark.id = call.id;
  remark.revision = revision;
  Result<AnnotationRow> row = store.remarks.ReplaceAnnotation(remark, ActorOf(call));
  if (!row.ok()) return Refused(call, store.remarks, row.status());
  return WithETag(JsonResponse(AnnotationJson(call, *row)), row->revision);
}

Result<Response> DeleteAnnotation(const Call& call, Store& store) {
  ENAMEL_ASSIGN_OR_RETURN(AnnotationRow stored, OwnAnnotation(call, store));
  ENAMEL_ASSIGN_OR_RETURN(int32_t revision, IfMatch(call.request));
  Status done = store.remarks.DeleteAnnotation(call.id, revision, ActorOf(call));
  return done.ok() ? Done() : Refused(call, store.remarks, done);
}

Result<Response> FileAppeal(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, SeeAttempt(call, store, call.id));
  if (seen.row.person != call.caller->person.id) {
    return Status(Code::kForbidden, "only the person who made the attempt can do this");
  }
  if (!CanAppeal(call.caller->person, seen.row)) {
    return Status(Code::kConflict,
                  "the score is not released yet, so there is nothing to appeal against");
  }
  BodyReader body(call.request);
  std::string text = body.Text("text", 1, kMaxRemarkBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  ENAMEL_RETURN_IF_ERROR(store.appeals.FileAppeal(call.id, text, ActorOf(call)));
  ENAMEL_ASSIGN_OR_RETURN(Response response, AttemptResponse(call, store, call.id));
  response.status = 201;
  return response;
}

Result<Response> AnswerAppeal(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  ENAMEL_ASSIGN_OR_RETURN(SeenAttempt seen, ReviewAttempt(call, store, call.id));
  BodyReader body(call.request);
  std::string outcome = body.Text("outcome", 1, 16);
  std::string answer = body.Text("answer", 1, kMaxRemarkBytes);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  if (outcome != "regrade" && outcome != "reject") {
    return Status(Code::kInvalidInput, "expected regrade or reject, found \"" + outcome + "\"",
                  "outcome");
  }
  ENAMEL_RETURN_IF_ERROR(
      store.appeals.AnswerAppeal(call.id, outcome == "regrade", answer, ActorOf(call)));
  return AttemptResponse(call, store, call.id);
}

Result<Response> WithdrawReference(const Call& call, Store& store) {
  Status none{Code::kNotFound, "there is no such reference", "id"};
  Result<ReferenceRow> row = store.references.ReferenceById(call.id);
  if (!row.ok()) {
    return row.status().code() == Code::kNotFound ? none : row.status();
  }
  // The right depends on the cut's author, whom the attempt names.
  ENAMEL_ASSIGN_OR_RETURN(AttemptRow attempt, store.attempts.AttemptById(row->attempt));
  const Person& viewer = call.caller->person;
  ENAMEL_ASSIGN_OR_RETURN(bool teaches, store.attempts.Teaches(viewer.id, attempt.id));
  if (!CanMarkReference(viewer, attempt, teaches)) {
    return Status(Code::kForbidden, "only instructors of this attempt's cohort can do this");
  }
  return DoneOr(store.references.WithdrawReference(call.id, ActorOf(call)));
}

Result<Response> CancelJob(const Call& call, Store& store) {
  return DoneOr(store.jobs.CancelJob(call.id, ActorOf(call)));
}

}  // namespace enamel::server::http
