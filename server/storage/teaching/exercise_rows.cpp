#include "server/storage/teaching/exercise_rows.h"

#include <optional>
#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/audit/decisions.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/teaching/assignment_rows.h"
#include "server/storage/teaching/exercise_owners.h"
#include "server/training/revision.h"
#include "server/training/ticket_rules.h"

// Exercises: drafts, published versions, retired ones.
namespace enamel::server {
namespace {

constexpr char kSelect[] = "SELECT " ENAMEL_EXERCISE_COLUMNS
                           " FROM exercises e " ENAMEL_EXERCISE_OWNERS "WHERE e.tenant = ?1";

}  // namespace

Result<ExerciseRow> FindExercise(Db& db, const Uuid& id) {
  Query q(db, std::string(kSelect) + " AND e.id = ?2");
  return q.Bind(id).One<ExerciseRow>("no exercise " + id.Text());
}

namespace {

// A published version never changes: attempts name it, and their scores depend on it.
Result<ExerciseRow> FindDraft(Db& db, const Uuid& id, int32_t revision) {
  auto row = FindExercise(db, id);
  ENAMEL_RETURN_IF_ERROR(row.status());
  if (row->state != ExerciseState::kDraft) {
    return Status(Code::kConflict, "expected a draft, version " + std::to_string(row->version) +
                                       " of \"" + row->name + "\" is " +
                                       ExerciseStateName(row->state) +
                                       " and never changes; put a new draft of that name");
  }
  ENAMEL_RETURN_IF_ERROR(MustBeRevision(row->revision, revision));
  return row;
}

// The newest version of a name, whatever became of it; drafts are none.
Result<std::optional<ExerciseRow>> NewestVersion(Db& db, const std::string& name) {
  Query q(db, std::string(kSelect) +
                  " AND e.name = ?2 AND e.version > 0 ORDER BY e.version DESC LIMIT 1");
  return q.Bind(name).Maybe<ExerciseRow>();
}

std::string VersionJson(const ExerciseRow& row) {
  return JsonOf({{"name", row.name},
                 {"version", std::to_string(row.version)},
                 {"content", row.content.Hex()},
                 {"state", ExerciseStateName(row.state)}});
}

Status InsertExercise(Db& db, const ExerciseRow& row) {
  return Insert(db, "exercises", "id", row.id, "name", row.name, "version", row.version, "title",
                row.title, "content", row.content, "scene", row.scene, "graded", row.graded,
                "published_ms", row.published_ms, "state", row.state);
}

Status NoSuchScene(const ExerciseRow& row) {
  return Status(Code::kNotFound,
                "the exercise's scene " + row.scene.Hex() + " is not stored; put the scene first",
                "scene_sha256");
}

Status SceneMustExist(Db& db, const ExerciseRow& row) {
  Query q(db, "SELECT 1 FROM scenes WHERE tenant = ?1 AND content = ?2");
  if (q.Bind(row.scene).Next()) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(q.status());
  return NoSuchScene(row);
}

Status SetState(Db& db, const Uuid& id, ExerciseState state) {
  Query q(db,
          "UPDATE exercises SET state = ?3, revision = revision + 1 WHERE tenant = ?1 AND id = ?2");
  return q.Bind(id, state).Run();
}

Status ChangeState(Db& db, const Uuid& version, ExerciseState to, const char* action,
                   const Actor& by, const std::string& reason) {
  ENAMEL_ASSIGN_OR_RETURN(const auto before, FindExercise(db, version));
  ENAMEL_RETURN_IF_ERROR(SetState(db, version, to));
  ENAMEL_ASSIGN_OR_RETURN(const auto after, FindExercise(db, version));
  const std::string now = reason.empty() ? VersionJson(after)
                                         : JsonOf({{"name", after.name},
                                                   {"version", std::to_string(after.version)},
                                                   {"content", after.content.Hex()},
                                                   {"state", ExerciseStateName(after.state)},
                                                   {"reason", reason}});
  return WriteAudit(db, by, action, version.Text(), VersionJson(before), now);
}

Result<std::vector<Uuid>> VersionsIn(Db& db, const std::string& name, ExerciseState state) {
  Query q(db, "SELECT id FROM exercises WHERE tenant = ?1 AND name = ?2 AND state = " + Sql(state) +
                  " ORDER BY version");
  return q.Bind(name).All<Uuid>();
}

// Publishing a retired exercise offers it again.
Status OfferAgain(Db& db, ExerciseRow& row, const Actor& by) {
  if (row.state == ExerciseState::kPublished) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(SetState(db, row.id, ExerciseState::kPublished));
  std::string before = VersionJson(row);
  row.state = ExerciseState::kPublished;
  ++row.revision;
  return WriteAudit(db, by, "exercise.publish", row.id.Text(), before, VersionJson(row));
}

// Publishing again must not give a cohort its work twice. An exercise offered without terms admits
// every hand, simulated ones too: the demo, a load test, a school's first look.
Status AssignOnce(Db& db, const ExerciseRow& version, const Uuid& cohort, const Actor& by) {
  Query q(
      db,
      "INSERT INTO assignments (tenant, id, exercise_name, cohort, created_ms, hands, exercise) "
      "SELECT ?1, ?2, ?3, ?4, ?5, ?6, ?7 WHERE NOT EXISTS (SELECT 1 FROM assignments a "
      "WHERE a.tenant = ?1 AND a.exercise_name = ?3 AND a.cohort = ?4)");
  const Uuid id = Uuid::New();
  ENAMEL_RETURN_IF_ERROR(
      q.Bind(id, version.name, cohort, NowMs(), HandsAllowed::kAny, version.id).Run());
  return db.Changes() == 0 ? Status::Ok() : NoteAssignment(db, id, by);
}

}  // namespace

// An exam's exercise must not change while the exam is open or somebody takes it.
Status NoExamMustBeOpen(Db& db, const std::string& name, const std::optional<Uuid>& assignment) {
  Query q(db,
          "SELECT a.id, coalesce(c.name, ''), a.due_ms FROM assignments a LEFT JOIN cohorts c ON "
          "c.tenant = a.tenant AND c.id = a.cohort WHERE a.tenant = ?1 AND a.exercise_name = ?2 "
          "AND a.exam = 1 AND (a.id = ?5 OR ?5 = ?6) AND ((a.opens_ms <= ?3 AND (a.due_ms = 0 OR "
          "a.due_ms >= ?3)) OR EXISTS "
          "(SELECT 1 FROM attempts t WHERE t.tenant = a.tenant AND t.assignment = a.id AND t.exam "
          "= 1 AND (t.state = " +
              Sql(AttemptState::kRecording) + " OR (t.state = " + Sql(AttemptState::kTicketed) +
              " AND t.ticketed_ms >= ?4)) AND t.flags & " + Sql(kExcused | kReturned) +
              " = 0)) "
              "LIMIT 1");
  UnixMs now_ms = NowMs();
  q.Bind(name, now_ms, now_ms - kExamTicketValidMs);
  // A zero id stands for any.
  if (!q.Bind(assignment.value_or(Uuid{}), Uuid{}).Next()) return q.status();
  std::string cohort = q.Text(1).empty() ? "everybody" : "\"" + q.Text(1) + "\"";
  std::string due = q.Int(2) == 0 ? ", without a due time" : ", due " + TimeText(q.Int(2));
  return Status(Code::kConflict,
                "\"" + name + "\" is the exam of assignment " + q.Id(0).Text() + " for " + cohort +
                    due + ", which is open or being taken; wait for its end, or end the assignment",
                "assignment");
}

Result<std::optional<ExerciseRow>> OfferedVersion(Db& db, const std::string& name) {
  Query q(db, std::string(kSelect) + " AND e.name = ?2 AND e.state = " +
                  Sql(ExerciseState::kPublished) + " ORDER BY e.version DESC LIMIT 1");
  return q.Bind(name).Maybe<ExerciseRow>();
}

Result<ExerciseRow> ExerciseRows::PublishExercise(ExerciseRow exercise, const Uuid& cohort,
                                                  const Actor& by) {
  ExerciseRow row;
  Status status = rows_.Write([&](Db& db) -> Status {
    row = exercise;
    ENAMEL_ASSIGN_OR_RETURN(auto newest, NewestVersion(db, row.name));
    // The same document is the same version, so that publishing twice changes nothing.
    if (newest && newest->content == row.content) {
      row = *newest;
      ENAMEL_RETURN_IF_ERROR(AssignOnce(db, row, cohort, by));
      return OfferAgain(db, row, by);
    }
    // A station that gets the exercise asks for the scene next.
    ENAMEL_RETURN_IF_ERROR(SceneMustExist(db, row));
    row.id = Uuid::New();
    row.version = newest ? newest->version + 1 : 1;
    row.published_ms = NowMs();
    row.state = ExerciseState::kPublished;
    ENAMEL_RETURN_IF_ERROR(InsertExercise(db, row));
    ENAMEL_RETURN_IF_ERROR(OwnName(db, row.name, by));
    ENAMEL_RETURN_IF_ERROR(AssignOnce(db, row, cohort, by));
    return WriteAudit(db, by, "exercise.publish", row.id.Text(), "{}", VersionJson(row));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return ExerciseById(row.id);
}

Result<ExerciseRow> ExerciseRows::PutDraft(const ExerciseRow& draft, const Actor& by) {
  ExerciseRow row = draft;
  row.id = Uuid::New();
  row.version = 0;
  row.published_ms = NowMs();
  row.state = ExerciseState::kDraft;
  row.revision = 1;
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(SceneMustExist(db, row));
    ENAMEL_RETURN_IF_ERROR(Explain(InsertExercise(db, row),
                                   "there is a draft of \"" + row.name + "\" already; replace it"));
    ENAMEL_RETURN_IF_ERROR(OwnName(db, row.name, by));
    return WriteAudit(db, by, "exercise.draft", row.id.Text(), "{}", VersionJson(row));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return ExerciseById(row.id);
}

Result<ExerciseRow> ExerciseRows::ReplaceDraft(const ExerciseRow& draft, const Actor& by) {
  ExerciseRow row;
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto found, FindDraft(db, draft.id, draft.revision));
    ENAMEL_RETURN_IF_ERROR(SceneMustExist(db, draft));
    std::string before = VersionJson(found);
    row = draft;
    row.version = 0;
    row.state = ExerciseState::kDraft;
    row.published_ms = NowMs();
    ++row.revision;
    Query q(db,
            "UPDATE exercises SET name = ?3, title = ?4, content = ?5, scene = ?6, graded = ?7, "
            "published_ms = ?8, revision = ?9 WHERE tenant = ?1 AND id = ?2");
    q.Bind(row.id, row.name, row.title, row.content, row.scene, row.graded, row.published_ms,
           row.revision);
    ENAMEL_RETURN_IF_ERROR(
        Explain(q.Run(), "there is another draft named \"" + row.name + "\"; replace that one"));
    if (row.name != found.name) {
      ENAMEL_RETURN_IF_ERROR(OwnName(db, row.name, by));
      ENAMEL_RETURN_IF_ERROR(FreeUnusedName(db, found.name, by));
    }
    return WriteAudit(db, by, "exercise.draft", row.id.Text(), before, VersionJson(row));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return ExerciseById(row.id);
}

Status ExerciseRows::DeleteDraft(const Uuid& id, int32_t revision, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindDraft(db, id, revision));
    Query q(db, "DELETE FROM exercises WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id).Run());
    ENAMEL_RETURN_IF_ERROR(FreeUnusedName(db, row.name, by));
    return WriteAudit(db, by, "exercise.discard", id.Text(), VersionJson(row), "{}");
  });
}

Result<ExerciseRow> ExerciseRows::PublishDraft(const Uuid& id, int32_t revision, const Actor& by) {
  ExerciseRow row;
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto found, FindDraft(db, id, revision));
    row = found;
    ENAMEL_ASSIGN_OR_RETURN(auto newest, NewestVersion(db, row.name));
    // A version that differs in nothing would split a class's results in two.
    if (newest && newest->content == row.content && newest->state == ExerciseState::kPublished) {
      return Status(Code::kConflict, "the draft is the same as version " +
                                         std::to_string(newest->version) + " of \"" + row.name +
                                         "\" says; change it first, or discard it");
    }
    row.version = newest ? newest->version + 1 : 1;
    row.state = ExerciseState::kPublished;
    row.published_ms = NowMs();
    ++row.revision;
    Query q(db, "UPDATE exercises SET version = ?3, state = " + Sql(ExerciseState::kPublished) +
                    ", published_ms = ?4, revision = ?5 "
                    "WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id, row.version, row.published_ms, row.revision).Run());
    return WriteAudit(db, by, "exercise.publish", id.Text(), VersionJson(found), VersionJson(row));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return ExerciseById(row.id);
}

// All versions of the name: an older one must not come back in place of the newest.
Status ExerciseRows::RetireExercise(const Uuid& id, const Actor& by, const std::string& reason) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindExercise(db, id));
    ENAMEL_RETURN_IF_ERROR(NoExamMustBeOpen(db, row.name, {}));
    ENAMEL_ASSIGN_OR_RETURN(const auto versions,
                            VersionsIn(db, row.name, ExerciseState::kPublished));
    if (versions.empty()) {
      return Status(Code::kConflict, "no version of \"" + row.name + "\" is published");
    }
    for (const Uuid& version : versions) {
      ENAMEL_RETURN_IF_ERROR(
          ChangeState(db, version, ExerciseState::kRetired, "exercise.retire", by, reason));
    }
    return Status::Ok();
  });
}

Status ExerciseRows::OfferExerciseAgain(const Uuid& id, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindExercise(db, id));
    ENAMEL_ASSIGN_OR_RETURN(const auto versions, VersionsIn(db, row.name, ExerciseState::kRetired));
    if (versions.empty()) {
      return Status(Code::kConflict, "no version of \"" + row.name + "\" is retired");
    }
    for (const Uuid& version : versions) {
      ENAMEL_RETURN_IF_ERROR(
          ChangeState(db, version, ExerciseState::kPublished, "exercise.publish", by, {}));
    }
    return Status::Ok();
  });
}

Result<ExerciseRow> ExerciseRows::ExerciseById(const Uuid& id) {
  return rows_.Read([&](Db& db) { return FindExercise(db, id); });
}

Result<ExerciseRow> ExerciseRows::ExerciseByContent(const Sha256& content) {
  return rows_.Read([&](Db& db) -> Result<ExerciseRow> {
    Query q(db, std::string(kSelect) +
                    " AND e.content = ?2 AND e.version > 0 ORDER BY e.version DESC LIMIT 1");
    return q.Bind(content).One<ExerciseRow>("no exercise with the content " + content.Hex());
  });
}

// Assigned to an active cohort of the person's, or to everybody (the zero id); of retired
// exercises, those that can still be done.
Result<std::vector<ExerciseRow>> ExerciseRows::ExercisesFor(const Uuid& person) {
  return rows_.Read([&](Db& db) -> Result<std::vector<ExerciseRow>> {
    Query q(db, "SELECT " ENAMEL_EXERCISE_COLUMNS " FROM exercises e " ENAMEL_EXERCISE_OWNERS
                "WHERE e.tenant = ?1 AND e.state <> " +
                    Sql(ExerciseState::kDraft) +
                    " AND EXISTS (SELECT 1 FROM assignments a WHERE a.tenant = e.tenant AND "
                    "a.exercise = e.id AND (e.state = " +
                    Sql(ExerciseState::kPublished) +
                    " OR a.due_ms = 0 OR a.due_ms > ?4 OR a.late_allowed = 1) AND (a.cohort = ?3 "
                    "OR a.cohort IN (SELECT m.cohort "
                    "FROM cohort_members m JOIN cohorts c ON c.tenant = m.tenant AND c.id = "
                    "m.cohort AND c.archived_ms = 0 WHERE m.tenant = ?1 AND m.person = ?2))) "
                    "ORDER BY e.name, e.version DESC");
    return q.Bind(person, Uuid{}, NowMs()).All<ExerciseRow>();
  });
}

Result<std::vector<ExerciseRow>> ExerciseRows::AllExercises() {
  return ExercisesIn(ExerciseState::kPublished);
}

Result<std::vector<ExerciseRow>> ExerciseRows::ExercisesIn(ExerciseState state) {
  return rows_.Read([&](Db& db) -> Result<std::vector<ExerciseRow>> {
    Query q(db, std::string(kSelect) +
                    " AND e.state = ?2 AND e.version = (SELECT max(version) FROM exercises n WHERE "
                    "n.tenant = "
                    "e.tenant AND n.name = e.name AND n.state = ?2) ORDER BY e.name");
    return q.Bind(state).All<ExerciseRow>();
  });
}

Result<std::vector<ExerciseRow>> ExerciseRows::ExerciseVersions(const std::string& name) {
  return rows_.Read([&](Db& db) -> Result<std::vector<ExerciseRow>> {
    Query q(db, std::string(kSelect) + " AND e.name = ?2 ORDER BY e.state = " +
                    Sql(ExerciseState::kDraft) + " DESC, e.version DESC");
    return q.Bind(name).All<ExerciseRow>();
  });
}

Result<ExerciseRow> ExerciseRows::ShareExercise(const Uuid& id, const SharingEdit& edit,
                                                const Actor& by) {
  Status status = rows_.Write([&](Db& db) { return ShareName(db, id, edit, by); });
  ENAMEL_RETURN_IF_ERROR(status);
  return ExerciseById(id);
}

}  // namespace enamel::server
