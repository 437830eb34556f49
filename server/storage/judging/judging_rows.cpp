#include "server/storage/judging/judging_rows.h"

#include <optional>
#include <string>

#include "server/storage/attempts/attempt_flags.h"
#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/attempts/job_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/judging/marking_rows.h"
#include "server/storage/teaching/assignment_rows.h"

// What people decide about an attempt, and scoring it again.
namespace enamel::server {
namespace {

std::string OverrideJson(const std::optional<ScoreOverride>& score) {
  if (!score) return "{}";
  return JsonOf({{"score", std::to_string(score->score)}, {"reason", score->reason}});
}

// The attempt as the caller has seen it.
// No revision: whoever asks has not shown the attempt to anybody.
Result<AttemptRow> FindSeen(Db& db, const Uuid& attempt, std::optional<int32_t> revision) {
  auto row = FindAttempt(db, attempt);
  if (row.ok() && revision) {
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(row->revision, *revision));
  }
  return row;
}

// Measuring alone does not decide a borderline score of graded work: a person has to have set it.
Status MustBeDecided(Db& db, const Uuid& attempt) {
  Query q(db,
          "SELECT 1 FROM attempts a JOIN exercises e ON e.tenant = a.tenant AND e.id = a.exercise "
          "WHERE a.tenant = ?1 AND a.id = ?2 AND (a.exam = 1 OR e.graded = 1) AND a.override_score "
          "IS NULL AND a.flags & " +
              Sql(kBorderlineScore) + " <> 0");
  const bool waits = q.Bind(attempt).Next();
  ENAMEL_RETURN_IF_ERROR(q.status());
  if (!waits) return Status::Ok();
  return Status(
      Code::kConflict,
      "the score of attempt " + attempt.Text() +
          " waits for a person: a limit lies within the uncertainty of what was measured. "
          "Set its score, the computed one or another, then release it",
      "borderline");
}

// Marks that are given after a score is known are not blind.
Status Release(Db& db, const Uuid& attempt, const Actor& by) {
  ENAMEL_RETURN_IF_ERROR(MustNotBeMarkedNow(db, attempt));
  ENAMEL_RETURN_IF_ERROR(MustBeDecided(db, attempt));
  return SetReleased(db, attempt, true, by);
}

}  // namespace

Status JudgingRows::ReleaseAttempt(const Uuid& attempt, const Actor& by,
                                   std::optional<int32_t> revision) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindSeen(db, attempt, revision));
    if (row.state != AttemptState::kScored) {
      return Status(Code::kConflict, "attempt " + attempt.Text() + " is " +
                                         AttemptStateName(row.state) +
                                         ", only a scored one can be released");
    }
    return row.released ? Status::Ok() : Release(db, attempt, by);
  });
}

Status JudgingRows::WithdrawRelease(const Uuid& attempt, const Actor& by,
                                    std::optional<int32_t> revision) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindSeen(db, attempt, revision));
    return row.released ? SetReleased(db, attempt, false, by) : Status::Ok();
  });
}

Status JudgingRows::OverrideScore(const Uuid& attempt, const std::optional<ScoreOverride>& score,
                                  const Actor& by, std::optional<int32_t> revision) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindSeen(db, attempt, revision));
    // An override is kept beside the score and its reasons and does not replace them.
    if (score && !row.score) {
      return Status(Code::kConflict, "attempt " + attempt.Text() + " is " +
                                         AttemptStateName(row.state) +
                                         " and has no score to override; wait for it");
    }
    if (!score && !row.overridden) return Status::Ok();
    {
      Query q(db,
              "UPDATE attempts SET override_score = ?3, override_reason = ?4, override_by = ?5, "
              "override_ms = ?6 WHERE tenant = ?1 AND id = ?2");
      q.Bind(attempt, score ? std::optional(score->score) : std::nullopt,
             score ? score->reason : std::string(), score ? std::optional(by.person) : std::nullopt,
             score ? NowMs() : 0);
      ENAMEL_RETURN_IF_ERROR(q.Run());
    }
    ENAMEL_RETURN_IF_ERROR(RaiseRevision(db, attempt));
    // Nobody decides any more.
    if (!score && row.released && (row.flags & kBorderlineScore) != 0)
      ENAMEL_RETURN_IF_ERROR(SetReleased(db, attempt, false, by));
    return WriteAudit(db, by, "attempt.override", attempt.Text(), OverrideJson(row.overridden),
                      OverrideJson(score));
  });
}

Status JudgingRows::FlagAttempt(const Uuid& attempt, uint32_t flags, const std::string& reason,
                                const Actor& by, std::optional<int32_t> revision) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindSeen(db, attempt, revision));
    return SetFlags(db, attempt, flags, reason, by);
  });
}

Status JudgingRows::ClearExcuse(const Uuid& attempt, const Actor& by,
                                std::optional<int32_t> revision) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto row, FindSeen(db, attempt, revision));
    if ((row.flags & kExcused) == 0) return Status::Ok();
    {
      Query q(db, "UPDATE attempts SET flags = flags - ?3 WHERE tenant = ?1 AND id = ?2");
      ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, kExcused).Run());
    }
    ENAMEL_RETURN_IF_ERROR(RaiseRevision(db, attempt));
    return WriteAudit(db, by, "attempt.unflag", attempt.Text(), JsonOf({{"flags", "excused"}}),
                      "{}");
  });
}

Status JudgingRows::Rescore(const Uuid& attempt, const std::string& cause, const Actor& by) {
  ENAMEL_RETURN_IF_ERROR(seals_.AcceptCommitted(attempt, by));
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindAttempt(db, attempt));
    ENAMEL_RETURN_IF_ERROR(QueueAgain(db, attempt, cause));
    return WriteAudit(db, by, "attempt.rescore", attempt.Text(),
                      JsonOf({{"state", AttemptStateName(row.state)},
                              {"problem", row.problem},
                              {"problem_field", row.problem_field}}),
                      JsonOf({{"cause", cause}}));
  });
}

// In one transaction: a class sees its scores at once or not at all.
Result<uint32_t> JudgingRows::ReleaseAssignment(const Uuid& id, const Actor& by) {
  uint32_t released = 0;
  Status status = rows_.Write([&](Db& db) -> Status {
    if (auto known = FindAssignment(db, id); !known.ok()) return known.status();
    Query scored(db, "SELECT id FROM attempts WHERE tenant = ?1 AND assignment = ?2 AND state = " +
                         Sql(AttemptState::kScored) + " AND released = 0");
    ENAMEL_ASSIGN_OR_RETURN(const auto attempts, scored.Bind(id).All<Uuid>());
    for (const Uuid& attempt : attempts) ENAMEL_RETURN_IF_ERROR(Release(db, attempt, by));
    released = static_cast<uint32_t>(attempts.size());
    return Status::Ok();
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return released;
}

// Queues a run; the attempt must have its whole recording.
Status QueueAgain(Db& db, const Uuid& attempt, const std::string& cause) {
  ENAMEL_ASSIGN_OR_RETURN(auto row, FindAttempt(db, attempt));
  Query q(
      db,
      "SELECT trace_blob IS NOT NULL, EXISTS (SELECT 1 FROM jobs j WHERE j.tenant = ?1 AND "
      "j.attempt = ?2 AND j.state IN ('queued', 'running')) FROM attempts WHERE tenant = ?1 AND "
      "id = ?2");
  q.Bind(attempt).Next();
  ENAMEL_RETURN_IF_ERROR(q.status());
  if (q.Int(0) == 0) {
    return Status(Code::kConflict,
                  row.expired_ms != 0
                      ? "the recording was removed by a retention rule; it cannot be scored again"
                      : std::string("the attempt is ") + AttemptStateName(row.state) +
                            "; only a sealed one can be scored");
  }
  // That run will see the change; a second one would only repeat it.
  if (q.Int(1) != 0) {
    return Status(Code::kConflict, "a scoring run of this attempt is waiting or under way already");
  }
  // Asking for a score is how an instructor lets a quarantined attempt in.
  if (row.state == AttemptState::kQuarantined) {
    Query accept(db, "UPDATE attempts SET state = " + Sql(AttemptState::kSealed) +
                         ", problem = '', problem_field = '' WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(accept.Bind(attempt).Run());
  }
  return QueueScoreJob(db, attempt, cause);
}

}  // namespace enamel::server
