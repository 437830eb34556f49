#include "server/storage/judging/reference_rows.h"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/attempts/job_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"

// The cuts that attempts are compared with.
namespace enamel::server {
namespace {

// The cut itself, which is now compared with itself; runs under way, which may have looked for
// references before this one was added; and where it is the only one that counts, attempts that the
// exercise's own target has judged for want of one.
Status QueueScoredWithout(Db& db, const ReferenceRow& row) {
  Query q(db,
          "SELECT a.id FROM attempts a WHERE a.tenant = ?1 AND a.exercise = ?2 AND a.expired_ms = "
          "0 AND (a.id = ?3 OR a.state IN (" +
              Sql(AttemptState::kSealed) + ", " + Sql(AttemptState::kScoring) +
              ") OR (a.state = " + Sql(AttemptState::kScored) +
              " AND a.reference IS NULL AND NOT EXISTS (SELECT 1 FROM reference_cuts r WHERE "
              "r.tenant = a.tenant AND r.exercise = a.exercise AND r.id <> ?4 AND r.withdrawn_ms "
              "= 0))) AND NOT EXISTS (SELECT 1 FROM jobs j WHERE j.tenant = a.tenant AND "
              "j.attempt = a.id AND j.state = 'queued')");
  ENAMEL_ASSIGN_OR_RETURN(const auto waiting,
                          q.Bind(row.exercise, row.attempt, row.id).All<Uuid>());
  for (const Uuid& attempt : waiting) {
    ENAMEL_RETURN_IF_ERROR(QueueScoreJob(db, attempt, "reference"));
  }
  return Status::Ok();
}

Status InsertReference(Db& db, ReferenceRow& row) {
  Query q(
      db,
      "SELECT coalesce(max(version), 0) FROM reference_cuts WHERE tenant = ?1 AND exercise = ?2");
  // Counted in the writing transaction, so that no two get the same.
  ENAMEL_ASSIGN_OR_RETURN(const int32_t newest, q.Bind(row.exercise).Value<int32_t>());
  row.version = newest + 1;
  return Insert(db, "reference_cuts", "id", row.id, "exercise", row.exercise, "attempt",
                row.attempt, "dentist", row.dentist, "version", row.version, "created_ms",
                row.created_ms, "consent", row.consent);
}

#define ENAMEL_REFERENCE_SELECT                                                             \
  "SELECT id, exercise, attempt, dentist, version, created_ms, consent, withdrawn_ms FROM " \
  "reference_cuts WHERE tenant = ?1"

// A cut that does not do the task would make everybody's score 0.
Status MustDoTheTask(const AttemptRow& attempt) {
  if (!attempt.critical_fail && attempt.score.value_or(0) > 0) return Status::Ok();
  return Status(
      Code::kConflict,
      "attempt " + attempt.id.Text() +
          " scored 0: an attempt that fails the task cannot be the reference; if the reference it "
          "was compared with is wrong, withdraw that one and score the attempt again",
      "score");
}

// Marked again, perhaps under another dentist's name: it counts once, with the newest data.
Status WithdrawEarlier(Db& db, const Uuid& attempt) {
  Query q(db,
          "UPDATE reference_cuts SET withdrawn_ms = ?3 WHERE tenant = ?1 AND attempt = ?2 AND "
          "withdrawn_ms = 0");
  return q.Bind(attempt, NowMs()).Run();
}

Result<ReferenceRow> FindReference(Db& db, const Uuid& id) {
  Query q(db, ENAMEL_REFERENCE_SELECT " AND id = ?2");
  return q.Bind(id).One<ReferenceRow>("no reference " + id.Text());
}

}  // namespace

Result<ReferenceRow> ReferenceRows::AddReference(const Uuid& attempt, const std::string& dentist,
                                                 bool consent, const Actor& by,
                                                 const std::string& anyway) {
  ReferenceRow row;
  row.consent = consent;
  row.id = Uuid::New();
  row.attempt = attempt;
  row.dentist = dentist;
  row.created_ms = NowMs();
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto found, FindAttempt(db, attempt));
    if (found.state != AttemptState::kScored) {
      return Status(Code::kConflict, "attempt " + attempt.Text() + " is " +
                                         AttemptStateName(found.state) +
                                         ", only a scored one can become a reference");
    }
    // Others are compared with the cut itself, not with its score.
    if (found.expired_ms != 0) {
      return Status(Code::kConflict, "the recording of attempt " + attempt.Text() +
                                         " was removed by a retention rule, so it can no longer "
                                         "become a reference");
    }
    row.exercise = found.exercise;
    ENAMEL_RETURN_IF_ERROR(MustDoTheTask(found));
    ENAMEL_RETURN_IF_ERROR(WithdrawEarlier(db, attempt));
    ENAMEL_RETURN_IF_ERROR(InsertReference(db, row));
    // Scores made beside an earlier reference stay until somebody asks.
    ENAMEL_RETURN_IF_ERROR(QueueScoredWithout(db, row));
    const std::string exercise = row.exercise.Text(), version = std::to_string(row.version);
    return WriteAudit(
        db, by, "reference.add", attempt.Text(), "{}",
        anyway.empty()
            ? JsonOf({{"exercise", exercise}, {"version", version}})
            : JsonOf({{"exercise", exercise}, {"version", version}, {"anyway", anyway}}));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return row;
}

Result<std::vector<ReferenceRow>> ReferenceRows::Counting(const Uuid& exercise) {
  ENAMEL_ASSIGN_OR_RETURN(auto rows, References(exercise));
  std::erase_if(rows, [](const ReferenceRow& row) { return row.withdrawn_ms != 0; });
  rows.resize(std::min(rows.size(), kMaxCounting));
  return rows;
}

Result<std::optional<ReferenceRow>> ReferenceRows::ReferenceFor(const Uuid& exercise) {
  ENAMEL_ASSIGN_OR_RETURN(const auto rows, Counting(exercise));
  return rows.empty() ? std::nullopt : std::optional(rows.front());
}

Result<std::set<Uuid>> ReferenceRows::ExercisesWithReference() {
  return rows_.Read([&](Db& db) -> Result<std::set<Uuid>> {
    Query q(db,
            "SELECT DISTINCT exercise FROM reference_cuts WHERE tenant = ?1 AND withdrawn_ms = 0");
    std::set<Uuid> out;
    while (q.Next()) out.insert(q.Id(0));
    ENAMEL_RETURN_IF_ERROR(q.status());
    return out;
  });
}

Result<ReferenceRow> ReferenceRows::ReferenceById(const Uuid& id) {
  return rows_.Read([&](Db& db) { return FindReference(db, id); });
}

Result<std::vector<ReferenceRow>> ReferenceRows::References(const Uuid& exercise) {
  return rows_.Read([&](Db& db) -> Result<std::vector<ReferenceRow>> {
    Query q(db, ENAMEL_REFERENCE_SELECT " AND exercise = ?2 ORDER BY version DESC");
    return q.Bind(exercise).All<ReferenceRow>();
  });
}

// It is marked and not deleted: scores that were compared with it still name it.
Status ReferenceRows::WithdrawReference(const Uuid& id, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindReference(db, id));
    if (row.withdrawn_ms != 0) return Status::Ok();
    Query q(db, "UPDATE reference_cuts SET withdrawn_ms = ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id, NowMs()).Run());
    return WriteAudit(
        db, by, "reference.withdraw", row.attempt.Text(),
        JsonOf({{"exercise", row.exercise.Text()}, {"version", std::to_string(row.version)}}),
        JsonOf({{"withdrawn", "yes"}}));
  });
}

}  // namespace enamel::server
