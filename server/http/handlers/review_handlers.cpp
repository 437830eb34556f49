#include <boost/json.hpp>

#include "server/http/error_response.h"
#include "server/http/etag.h"
#include "server/http/handlers/handlers.h"
#include "server/http/handlers/seen_attempt.h"
#include "server/http/json_body.h"
#include "server/http/kept.h"
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
Response AttemptResponse(const Call& call, Store& store, const Uuid& attempt) {
  Result<AttemptRow> row = store.attempts.AttemptById(attempt);
  if (!row.ok()) return ErrorResponse(row.status());
  AttemptView view(store, call.caller->person);
  Result<json::object> out = view.DetailJson(*row);
  if (!out.ok()) return ErrorResponse(out.status());
  return WithETag(JsonResponse(*out), row->revision);
}

Response JudgedOr(const Call& call, Store& store, const Status& status) {
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
Response Refused(const Call& call, RemarkRows& remarks, const Status& status) {
  if (status.field() != kStale) return ErrorResponse(status);
  Result<AnnotationRow> now = remarks.AnnotationById(call.id);
  if (!now.ok()) return ErrorResponse(now.status());
  return Stale(status, AnnotationJson(call, *now), now->revision);
}

}  // namespace

Response WithdrawRelease(const Call& call, Store& store) {
  Result<SeenAttempt> seen = ReviewAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  Result<int32_t> revision = IfMatch(call.request);
  if (!revision.ok()) return ErrorResponse(revision.status());
  Status done = store.judging.WithdrawRelease(call.id, ActorOf(call), *revision);
  return done.ok() ? Done() : JudgedMeanwhile(call, store, done);
}

Response PutOverride(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  Result<SeenAttempt> seen = ReviewAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  BodyReader body(call.request);
  ScoreOverride score;
  score.score = body.Number("score", 0, 100);
  score.reason = body.Text("reason", 1, kMaxReasonBytes);
  if (Status status = body.Finish(); !status.ok()) return ErrorResponse(status);
  Result<int32_t> revision = IfMatch(call.request);
  if (!revision.ok()) return ErrorResponse(revision.status());
  return JudgedOr(call, store,
                  store.judging.OverrideScore(call.id, score, ActorOf(call), *revision));
}

Response DeleteOverride(const Call& call, Store& store) {
  Result<SeenAttempt> seen = ReviewAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  Result<int32_t> revision = IfMatch(call.request);
  if (!revision.ok()) return ErrorResponse(revision.status());
  return JudgedOr(call, store,
                  store.judging.OverrideScore(call.id, std::nullopt, ActorOf(call), *revision));
}

Response Rescore(const Call& call, Store& store) {
  Result<SeenAttempt> seen = ReviewAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  // No If-Match: it changes no judgement, and asking twice makes one more result, which is kept
  // with the others.
  Status done = store.judging.Rescore(call.id, "rescore", ActorOf(call));
  if (!done.ok()) return ErrorResponse(done);
  Response response = AttemptResponse(call, store, call.id);
  // Accepted: the job is in the queue and the score unchanged.
  if (response.status == 200) response.status = 202;
  return response;
}

Response Excuse(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  Result<SeenAttempt> seen = ReviewAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  BodyReader body(call.request);
  std::string reason = body.Text("reason", 1, kMaxReasonBytes);
  if (Status status = body.Finish(); !status.ok()) return ErrorResponse(status);
  Result<int32_t> revision = IfMatch(call.request);
  if (!revision.ok()) return ErrorResponse(revision.status());
  return JudgedOr(call, store,
                  store.judging.FlagAttempt(call.id, kExcused, reason, ActorOf(call), *revision));
}

Response TakeExcuseBack(const Call& call, Store& store) {
  Result<SeenAttempt> seen = ReviewAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  Result<int32_t> revision = IfMatch(call.request);
  if (!revision.ok()) return ErrorResponse(revision.status());
  return JudgedOr(call, store, store.judging.ClearExcuse(call.id, ActorOf(call), *revision));
}

Response RestoreResult(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  Result<SeenAttempt> seen = ReviewAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  BodyReader body(call.request);
  const auto run = static_cast<int32_t>(body.Integer("run", 1, kMaxRun));
  if (Status status = body.Finish(); !status.ok()) return ErrorResponse(status);
  Result<int32_t> revision = IfMatch(call.request);
  if (!revision.ok()) return ErrorResponse(revision.status());
  return JudgedOr(call, store, store.results.RestoreResult(call.id, run, ActorOf(call), *revision));
}

Response ListResults(const Call& call, Store& store) {
  Result<SeenAttempt> seen = SeeAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  if (!CanSeeScore(call.caller->person, seen->row, seen->graded, seen->teaches)) {
    return ErrorResponse(
        {Code::kForbidden,
         "this work is graded: the results show after the instructor has released it"});
  }
  if (Status hidden = ScoreMustNotBeHidden(call, store, call.id); !hidden.ok()) {
    return ErrorResponse(hidden);
  }
  Result<Page> page = PageOf(call.request, kMaxPage, kMaxPage);
  if (!page.ok()) return ErrorResponse(page.status());
  Result<std::vector<ResultRow>> rows = store.results.ResultsOf(call.id);
  if (!rows.ok()) return ErrorResponse(rows.status());
  const int32_t newest = rows->empty() ? 0 : rows->front().run;
  json::value next = CutPage(*rows, *page, [](const ResultRow& row) {
    return FallingKey(static_cast<uint64_t>(row.run));
  });
  json::array results;
  for (const ResultRow& row : *rows) {
    json::value reference;
    if (row.reference) reference = row.reference->Text();
    Result<Bytes> text = store.blobs.GetBlob(row.score_json);
    if (!text.ok()) return ErrorResponse(Status{Code::kInternal, text.status().message()});
    json::error_code error;
    // Parsed and put in as JSON, so that a damaged document is found here and not by the page.
    json::value score = json::parse(AsText(*text), error);
    if (error) return ErrorResponse(Status{Code::kInternal, "stored score is no JSON"});
    results.push_back(
        {{"run", row.run},
         {"scored_ms", row.scored_ms},
         {"cause", row.cause},
         {"restorable", row.is_whole && row.run != newest && seen->row.expired_ms == 0},
         {"reference_attempt", std::move(reference)},
         {"replay_realtime_factor", row.replay_realtime_factor},
         {"score", std::move(score)}});
  }
  return Packed(call.request,
                JsonResponse({{"results", std::move(results)}, {"next", std::move(next)}}));
}

Response ListAnnotations(const Call& call, Store& store) {
  Result<SeenAttempt> seen = SeeAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  if (!CanSeeScore(call.caller->person, seen->row, seen->graded, seen->teaches)) {
    return ErrorResponse(
        {Code::kForbidden,
         "this work is graded: remarks show after the instructor has released it"});
  }
  Result<Page> page = PageOf(call.request, kMaxPage, kMaxPage);
  if (!page.ok()) return ErrorResponse(page.status());
  Result<std::vector<AnnotationRow>> rows = store.remarks.AnnotationsOf(call.id);
  if (!rows.ok()) return ErrorResponse(rows.status());
  json::value next = CutPage(
      *rows, *page, [](const AnnotationRow& row) { return RisingKey(row.tick) + row.id.Text(); });
  json::array annotations;
  for (const AnnotationRow& row : *rows) annotations.push_back(AnnotationJson(call, row));
  return JsonResponse({{"annotations", std::move(annotations)}, {"next", std::move(next)}});
}

Response AddAnnotation(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  Result<SeenAttempt> seen = ReviewAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  Result<AnnotationRow> remark = RemarkIn(call);
  if (!remark.ok()) return ErrorResponse(remark.status());
  remark->attempt = call.id;
  Result<AnnotationRow> row = store.remarks.AddAnnotation(*remark, ActorOf(call));
  if (!row.ok()) return ErrorResponse(row.status());
  return WithETag(JsonResponse(AnnotationJson(call, *row), 201), row->revision);
}

Response ReplaceAnnotation(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  Result<AnnotationRow> stored = OwnAnnotation(call, store);
  if (!stored.ok()) return ErrorResponse(stored.status());
  Result<int32_t> revision = IfMatch(call.request);
  if (!revision.ok()) return ErrorResponse(revision.status());
  Result<AnnotationRow> remark = RemarkIn(call);
  if (!remark.ok()) return ErrorResponse(remark.status());
  remark->id = call.id;
  remark->revision = *revision;
  Result<AnnotationRow> row = store.remarks.ReplaceAnnotation(*remark, ActorOf(call));
  if (!row.ok()) return Refused(call, store.remarks, row.status());
  return WithETag(JsonResponse(AnnotationJson(call, *row)), row->revision);
}

Response DeleteAnnotation(const Call& call, Store& store) {
  Result<AnnotationRow> stored = OwnAnnotation(call, store);
  if (!stored.ok()) return ErrorResponse(stored.status());
  Result<int32_t> revision = IfMatch(call.request);
  if (!revision.ok()) return ErrorResponse(revision.status());
  Status done = store.remarks.DeleteAnnotation(call.id, *revision, ActorOf(call));
  return done.ok() ? Done() : Refused(call, store.remarks, done);
}

Response FileAppeal(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  Result<SeenAttempt> seen = SeeAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  if (seen->row.person != call.caller->person.id) {
    return ErrorResponse({Code::kForbidden, "only the person who made the attempt can do this"});
  }
  if (!CanAppeal(call.caller->person, seen->row)) {
    return ErrorResponse(
        {Code::kConflict, "the score is not released yet, so there is nothing to appeal against"});
  }
  BodyReader body(call.request);
  std::string text = body.Text("text", 1, kMaxRemarkBytes);
  if (Status status = body.Finish(); !status.ok()) return ErrorResponse(status);
  Status done = store.appeals.FileAppeal(call.id, text, ActorOf(call));
  if (!done.ok()) return ErrorResponse(done);
  Response response = AttemptResponse(call, store, call.id);
  if (response.status == 200) response.status = 201;
  return response;
}

Response AnswerAppeal(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  Result<SeenAttempt> seen = ReviewAttempt(call, store, call.id);
  if (!seen.ok()) return ErrorResponse(seen.status());
  BodyReader body(call.request);
  std::string outcome = body.Text("outcome", 1, 16);
  std::string answer = body.Text("answer", 1, kMaxRemarkBytes);
  if (Status status = body.Finish(); !status.ok()) return ErrorResponse(status);
  if (outcome != "regrade" && outcome != "reject") {
    return ErrorResponse(
        {Code::kInvalidInput, "expected regrade or reject, found \"" + outcome + "\"", "outcome"});
  }
  Status done = store.appeals.AnswerAppeal(call.id, outcome == "regrade", answer, ActorOf(call));
  return done.ok() ? AttemptResponse(call, store, call.id) : ErrorResponse(done);
}

Response WithdrawReference(const Call& call, Store& store) {
  Status none{Code::kNotFound, "there is no such reference", "id"};
  Result<ReferenceRow> row = store.references.ReferenceById(call.id);
  if (!row.ok()) {
    return ErrorResponse(row.status().code() == Code::kNotFound ? none : row.status());
  }
  // The right depends on the cut's author, whom the attempt names.
  Result<AttemptRow> attempt = store.attempts.AttemptById(row->attempt);
  if (!attempt.ok()) return ErrorResponse(attempt.status());
  const Person& viewer = call.caller->person;
  Result<bool> teaches = store.attempts.Teaches(viewer.id, attempt->id);
  if (!teaches.ok()) return ErrorResponse(teaches.status());
  if (!CanMarkReference(viewer, *attempt, *teaches)) {
    return ErrorResponse(
        {Code::kForbidden, "only instructors of this attempt's cohort can do this"});
  }
  return DoneOr(store.references.WithdrawReference(call.id, ActorOf(call)));
}

Response CancelJob(const Call& call, JobRows& jobs) {
  return DoneOr(jobs.CancelJob(call.id, ActorOf(call)));
}

}  // namespace enamel::server::http
