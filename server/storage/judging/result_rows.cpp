#include "server/storage/judging/result_rows.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "server/results/result_document.h"
#include "server/storage/attempts/attempt_flags.h"
#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/attempts/job_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/judging/motion_rows.h"
#include "server/storage/judging/timeline_rows.h"

// What scoring leaves.
namespace enamel::server {
namespace {

// An UPDATE that finds no row is no failure of SQL.
Status MustExist(Db& db, const Uuid& attempt) {
  if (db.Changes() > 0) return Status::Ok();
  return Status(Code::kNotFound, "no attempt " + attempt.Text());
}

// Whether the row has another score than the run's, unless it is the one that the run found to have
// the same points and reasons: that it still is, is seen in the transaction, as another run may
// have ended meanwhile.
constexpr char kIsAnother[] =
    "(score IS DISTINCT FROM ?3 OR critical_fail IS DISTINCT FROM ?4 OR score_json IS DISTINCT "
    "FROM ?5) AND score_json IS DISTINCT FROM ?6";

void BindAnother(Query& q, const AttemptResult& result) {
  q.Bind(result.score, result.critical_fail, result.score_json, result.same_judgement_as);
}

// No instructor has seen a released score that changes: graded work and exams need a new release.
Status WithdrawReleaseOfAnotherScore(Db& db, const Uuid& attempt, const AttemptResult& result) {
  Query q(db,
          "SELECT 1 FROM attempts a JOIN exercises e ON e.tenant = a.tenant AND e.id = a.exercise "
          "WHERE a.tenant = ?1 AND a.id = ?2 AND a.released = 1 AND (a.exam = 1 OR e.graded = 1 OR "
          "(a.flags & " +
              Sql(kReadmitted) + " <> 0 AND a.assignment IS NULL)) AND " + kIsAnother);
  BindAnother(q.Bind(attempt), result);
  bool another = q.Next();
  ENAMEL_RETURN_IF_ERROR(q.status());
  return another ? SetReleased(db, attempt, false, Actor{{}, "job"}) : Status::Ok();
}

// Of the newest run and the one before it all is kept, so that the newest can be taken back; of
// earlier ones the score and its reasons.
Status ForgetOldPictures(Db& db, const Uuid& attempt) {
  Query q(db,
          "UPDATE attempt_results SET final_volume = NULL, deviation = NULL, series = NULL WHERE "
          "tenant "
          "= ?1 AND attempt = ?2 AND run < (SELECT max(n.run) - 1 FROM attempt_results n WHERE "
          "n.tenant = ?1 AND n.attempt = ?2)");
  return q.Bind(attempt).Run();
}

// Every run is kept: a score that was released and then changed can be explained.
Status KeepResult(Db& db, const Uuid& attempt, const AttemptResult& result, const Uuid& lease) {
  Query q(
      db,
      "INSERT INTO attempt_results (tenant, attempt, run, scored_ms, cause, score, "
      "critical_fail, score_json, reference, replay_realtime_factor, document, final_volume, "
      "deviation, "
      "series) SELECT ?1, ?2, 1 + (SELECT coalesce(max(run), 0) FROM attempt_results WHERE tenant "
      "= "
      "?1 AND attempt = ?2), ?3, coalesce((SELECT cause FROM jobs WHERE tenant = ?1 AND lease = "
      "?8), "
      "'seal'), ?4, ?5, ?6, ?7, ?9, ?10, ?11, ?12, ?13");
  ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, result.scored_ms != 0 ? result.scored_ms : NowMs(),
                                result.score, result.critical_fail, result.score_json,
                                result.reference, lease, result.replay_realtime_factor,
                                result.document, result.final_volume, result.deviation,
                                result.series)
                             .Run());
  return ForgetOldPictures(db, attempt);
}

// What RestoreResult takes over. Whether its run may be taken: only the newest but one has kept all
// that belongs to it.
struct KeptRun {
  int64_t newest = 0;
  AttemptResult result;
};

Result<KeptRun> FindKept(Db& db, const Uuid& attempt, int32_t run) {
  Query q(
      db,
      "SELECT (SELECT max(n.run) FROM attempt_results n WHERE n.tenant = ?1 AND n.attempt = ?2), "
      "score, critical_fail, score_json, final_volume, deviation, series, reference, "
      "replay_realtime_factor, scored_ms, document FROM attempt_results WHERE tenant = ?1 AND "
      "attempt = ?2 AND run = ?3");
  if (!q.Bind(attempt, run).Next()) {
    ENAMEL_RETURN_IF_ERROR(q.status());
    return Status(Code::kNotFound,
                  "attempt " + attempt.Text() + " has no scoring run " + std::to_string(run),
                  "run");
  }
  KeptRun out{q.Int(0), {}};
  q.Read(1, out.result);
  if (run == out.newest || !out.result.deviation.IsZero()) return out;
  return Status(Code::kConflict,
                "of run " + std::to_string(run) +
                    " only points and reasons are kept, because it is neither the newest nor the "
                    "previous one; have the attempt scored again, or override its score",
                "run");
}

// The same run once more, so that the newest one stays the one that counts.
Status RepeatRun(Db& db, const Uuid& attempt, int32_t run) {
  Query q(
      db,
      "INSERT INTO attempt_results (tenant, attempt, run, scored_ms, cause, score, critical_fail, "
      "score_json, reference, replay_realtime_factor, document, final_volume, deviation, series) "
      "SELECT tenant, attempt, (SELECT 1 + max(n.run) FROM attempt_results n WHERE n.tenant = ?1 "
      "AND n.attempt = ?2), scored_ms, 'restore', score, critical_fail, score_json, reference, "
      "replay_realtime_factor, document, final_volume, deviation, series FROM attempt_results "
      "WHERE tenant = ?1 AND attempt = ?2 AND run = ?3");
  ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, run).Run());
  return ForgetOldPictures(db, attempt);
}

// The row of an attempt as its newest run left it.
Status SetResult(Db& db, const Uuid& attempt, const AttemptResult& result) {
  Query q(db, "UPDATE attempts SET state = " + Sql(AttemptState::kScored) +
                  ", progress = 1, problem = '', problem_field = '', score = ?3, critical_fail = "
                  "?4, score_json = ?5, "
                  "final_volume = ?6, deviation = ?7, series = ?8, reference = ?9 "
                  "WHERE tenant = ?1 AND id = ?2 AND state IN (" +
                  Sql(AttemptState::kSealed) + ", " + Sql(AttemptState::kScoring) + ", " +
                  Sql(AttemptState::kScored) + ", " + Sql(AttemptState::kFailed) + ")");
  ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, result.score, result.critical_fail, result.score_json,
                                result.final_volume, result.deviation, result.series,
                                result.reference)
                             .Run());
  if (db.Changes() > 0) return Status::Ok();
  return Status(Code::kConflict,
                "attempt " + attempt.Text() + " is not one that waits for a score");
}

// Runs that wait or are under way.
Status CancelRunsOf(Db& db, const Uuid& attempt, const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(const auto open, OpenRunsOf(db, attempt));
  for (const JobRow& job : open) ENAMEL_RETURN_IF_ERROR(CancelRun(db, job, by));
  return Status::Ok();
}

// A score that differs from the previous one.
Status RaiseRevisionForAnother(Db& db, const Uuid& attempt, const AttemptResult& result) {
  Query q(db,
          std::string(
              "UPDATE attempts SET revision = revision + 1 WHERE tenant = ?1 AND id = ?2 AND ") +
              kIsAnother);
  BindAnother(q.Bind(attempt), result);
  return q.Run();
}

}  // namespace

Result<std::string> ScoredJson(Db& db, const Uuid& attempt, const Sha256& score_json,
                               ByteView document) {
  std::string cause, motion;
  {
    Query q(
        db,
        "SELECT cause FROM attempt_results WHERE tenant = ?1 AND attempt = ?2 ORDER BY run DESC "
        "LIMIT 1");
    if (q.Bind(attempt).Next()) cause = q.Text(0);
    ENAMEL_RETURN_IF_ERROR(q.status());
  }
  // Not which attempt is the nearest: that one may be erased with its person.
  Query q(db,
          "SELECT content, others, nearest_um, median_um, size_um, presets, preset_um, tremor_nm, "
          "still_ppm, late_ppm, gap_ppm FROM motions WHERE tenant = ?1 AND attempt = ?2");
  if (q.Bind(attempt).Next()) {
    motion = q.Hash(0).Hex();
    for (int i = 1; i < 11; ++i) motion += " " + std::to_string(q.Int(i));
  }
  ENAMEL_RETURN_IF_ERROR(q.status());
  return JsonOf({{"score_json", score_json.Hex()},
                 {"result", HashSha256(document).Hex()},
                 {"cause", cause},
                 {"motion", motion}});
}

Status ResultRows::FinishAttempt(const Uuid& attempt, const AttemptResult& result,
                                 const Uuid& lease) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeRunning(db, lease));
    ENAMEL_RETURN_IF_ERROR(WithdrawReleaseOfAnotherScore(db, attempt, result));
    ENAMEL_RETURN_IF_ERROR(RaiseRevisionForAnother(db, attempt, result));
    ENAMEL_RETURN_IF_ERROR(SetResult(db, attempt, result));
    ENAMEL_RETURN_IF_ERROR(KeepResult(db, attempt, result, lease));
    ENAMEL_RETURN_IF_ERROR(WaitForTimeline(db, attempt));
    ENAMEL_RETURN_IF_ERROR(PutFlag(db, attempt, kShook, result.shook));
    ENAMEL_RETURN_IF_ERROR(PutFlag(db, attempt, kBorderlineScore, result.borderline));
    ENAMEL_RETURN_IF_ERROR(KeepMotion(db, attempt, result));
    ENAMEL_RETURN_IF_ERROR(blobs_.Hold(db, {result.score_json, result.final_volume,
                                            result.deviation, result.series, result.motion}));
    ENAMEL_ASSIGN_OR_RETURN(const auto scored,
                            ScoredJson(db, attempt, result.score_json, result.document));
    ENAMEL_RETURN_IF_ERROR(FinishRun(db, lease));
    return WriteAudit(db, Actor{{}, "job"}, kAuditScore, attempt.Text(), "{}", scored);
  });
}

Status ResultRows::RestoreResult(const Uuid& attempt, int32_t run, const Actor& by,
                                 std::optional<int32_t> revision) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto row, FindAttempt(db, attempt));
    if (revision) ENAMEL_RETURN_IF_ERROR(MustBeRevision(row.revision, *revision));
    if (row.expired_ms != 0) {
      return Status(Code::kConflict, "the recording of attempt " + attempt.Text() +
                                         " was removed by a retention rule; its score stays");
    }
    ENAMEL_ASSIGN_OR_RETURN(const auto kept, FindKept(db, attempt, run));
    ENAMEL_RETURN_IF_ERROR(CancelRunsOf(db, attempt, by));
    // It counts already; its planned replacement is cancelled.
    if (run == kept.newest) return Status::Ok();
    ENAMEL_RETURN_IF_ERROR(WithdrawReleaseOfAnotherScore(db, attempt, kept.result));
    ENAMEL_RETURN_IF_ERROR(RaiseRevisionForAnother(db, attempt, kept.result));
    ENAMEL_RETURN_IF_ERROR(SetResult(db, attempt, kept.result));
    ENAMEL_RETURN_IF_ERROR(RepeatRun(db, attempt, run));
    // An unsigned run's flags are not kept: the newest run's stay.
    if (const auto document = DecodeResult(kept.result.document); document.ok()) {
      const bool borderline = (document->flags & kBorderlineScore) != 0;
      ENAMEL_RETURN_IF_ERROR(PutFlag(db, attempt, kBorderlineScore, borderline));
    }
    ENAMEL_ASSIGN_OR_RETURN(const auto scored,
                            ScoredJson(db, attempt, kept.result.score_json, kept.result.document));
    return WriteAudit(db, by, kAuditRestore, attempt.Text(),
                      JsonOf({{"run", std::to_string(kept.newest)}}), scored);
  });
}

// An earlier score counts again: a run that fails takes nothing away that somebody has seen.
Status ResultRows::FailAttempt(const Uuid& attempt, const Status& problem, const Uuid& lease) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeRunning(db, lease));
    Query q(db, "UPDATE attempts SET state = CASE WHEN score IS NULL THEN " +
                    Sql(AttemptState::kFailed) + " ELSE " + Sql(AttemptState::kScored) +
                    " END, problem = ?3, problem_field = ?4, progress = "
                    "CASE WHEN score IS NULL THEN 0 ELSE 1 END WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, problem.message(), problem.field()).Run());
    ENAMEL_RETURN_IF_ERROR(MustExist(db, attempt));
    return WriteAudit(db, Actor{{}, "job"}, "attempt.fail", attempt.Text(), "{}",
                      JsonOf({{"problem", problem.message()}, {"problem_field", problem.field()}}));
  });
}

Result<AttemptResult> ResultRows::ResultOf(const Uuid& attempt) {
  return rows_.Read([&](Db& db) -> Result<AttemptResult> {
    Query q(db,
            "SELECT a.score, a.critical_fail, a.score_json, a.final_volume, a.deviation, a.series, "
            "a.reference, "
            "r.replay_realtime_factor, r.scored_ms, r.document FROM attempts a LEFT JOIN "
            "attempt_results r ON r.tenant = a.tenant AND r.attempt = a.id WHERE a.tenant = ?1 AND "
            "a.id = ?2 ORDER BY r.run DESC LIMIT 1");
    if (!q.Bind(attempt).Next()) {
      ENAMEL_RETURN_IF_ERROR(q.status());
      return Status(Code::kNotFound, "no attempt " + attempt.Text());
    }
    if (q.IsNull(2))
      return Status(Code::kConflict, "attempt " + attempt.Text() + " has no score yet");
    return q.Row<AttemptResult>();
  });
}

// By the run and not by the attempt: one that was cancelled must not move the next one's bar.
Status ResultRows::SetProgress(const Uuid& lease, double progress) {
  return rows_.WriteRow([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeRunning(db, lease));
    Query q(db, "UPDATE attempts SET progress = ?3 WHERE tenant = ?1 AND state = " +
                    Sql(AttemptState::kScoring) +
                    " AND id = (SELECT "
                    "attempt FROM jobs WHERE tenant = ?1 AND lease = ?2)");
    return q.Bind(lease, std::clamp(progress, 0.0, 1.0)).Run();
  });
}

Result<std::vector<ResultRow>> ResultRows::ResultsOf(const Uuid& attempt) {
  return rows_.Read([&](Db& db) -> Result<std::vector<ResultRow>> {
    Query q(db,
            "SELECT run, scored_ms, cause, score, critical_fail, score_json, reference, "
            "replay_realtime_factor, document, deviation IS NOT NULL FROM attempt_results WHERE "
            "tenant = ?1 AND attempt = "
            "?2 ORDER "
            "BY run DESC");
    return q.Bind(attempt).All<ResultRow>();
  });
}

}  // namespace enamel::server
