#include "server/storage/teaching/assignment_rows.h"

#include <algorithm>
#include <string>
#include <vector>

#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/teaching/exercise_rows.h"
#include "server/training/ticket_rules.h"

// Assignments: exercises for cohorts, with dates, limits and exams.
namespace enamel::server {
namespace {

#define ENAMEL_ASSIGNMENT_COLUMNS                                                         \
  "a.id, a.exercise_name, a.cohort, coalesce(c.name, ''), a.opens_ms, a.due_ms, "         \
  "a.attempt_limit, a.exam, a.late_allowed, a.revision, a.created_ms, a.hands, "          \
  "a.exercise, coalesce(v.version, 0), coalesce(v.title, ''), coalesce(v.state, 3) = 3, " \
  "a.counting, coalesce(v.graded, 0), a.sign_off, a.outline"
#define ENAMEL_ASSIGNMENTS                                                                  \
  "assignments a LEFT JOIN cohorts c ON c.tenant = a.tenant AND c.id = a.cohort LEFT JOIN " \
  "exercises v ON v.tenant = a.tenant AND v.id = a.exercise"
constexpr int kAssignmentColumns = 20;

AssignmentRow AssignmentOf(const Query& q) {
  AssignmentRow out;
  std::string counting, outline;
  q.Read(0, out.id, out.exercise, out.cohort, out.cohort_name, out.opens_ms, out.due_ms,
         out.attempt_limit, out.exam, out.late_allowed, out.revision, out.created_ms, out.hands,
         out.version_id, out.version, out.title, out.retired, counting, out.graded, out.sign_off,
         outline);
  out.counting = CountingFromName(counting).value_or(Counting::kBest);
  out.outline = OutlineShownFromName(outline).value_or(OutlineShown::kPractice);
  return out;
}

// Of an exam; none: it may be taken at any station.
Status AddStations(Db& db, AssignmentRow& row) {
  Query q(db,
          "SELECT station FROM assignment_stations WHERE tenant = ?1 AND assignment = ?2 ORDER BY "
          "station");
  q.Bind(row.id);
  while (q.Next()) row.stations.push_back(q.Id(0));
  return q.status();
}

}  // namespace

Result<AssignmentRow> FindAssignment(Db& db, const Uuid& id) {
  Query q(db, "SELECT " ENAMEL_ASSIGNMENT_COLUMNS " FROM " ENAMEL_ASSIGNMENTS
              " WHERE a.tenant = ?1 AND a.id = ?2");
  ENAMEL_ASSIGN_OR_RETURN(auto out, q.Bind(id).One(AssignmentOf, "no assignment " + id.Text()));
  ENAMEL_RETURN_IF_ERROR(AddStations(db, out));
  return out;
}

namespace {

// All of the terms: the audit trail must show what an exam was held under.
std::string TermsJson(const AssignmentRow& row) {
  std::string stations;
  for (const Uuid& station : row.stations)
    stations += (stations.empty() ? "" : " ") + station.Text();
  return JsonOf({{"exercise", row.exercise},
                 {"version", std::to_string(row.version)},
                 {"counting", CountingName(row.counting)},
                 {"cohort", row.cohort.Text()},
                 {"opens_ms", std::to_string(row.opens_ms)},
                 {"due_ms", std::to_string(row.due_ms)},
                 {"attempt_limit", std::to_string(row.attempt_limit)},
                 {"exam", row.exam ? "yes" : "no"},
                 {"late_allowed", row.late_allowed ? "yes" : "no"},
                 {"stations", stations},
                 {"hands", HandsAllowedName(row.hands)},
                 {"sign_off", row.sign_off ? "yes" : "no"},
                 {"outline", OutlineShownName(row.outline)}});
}

// Sets the row to the version offered now.
Status TakeNewestVersion(Db& db, AssignmentRow& row) {
  ENAMEL_ASSIGN_OR_RETURN(const auto offered, OfferedVersion(db, row.exercise));
  if (!offered) {
    return Status(Code::kInvalidInput,
                  "expected the name of a published exercise, found \"" + row.exercise + "\"",
                  "exercise");
  }
  row.version_id = offered->id;
  row.version = offered->version;
  return Status::Ok();
}

Status CohortMustBeKnown(Db& db, const AssignmentRow& row) {
  if (row.cohort.IsZero()) return Status::Ok();
  Query cohort(db, "SELECT 1 FROM cohorts WHERE tenant = ?1 AND id = ?2");
  ENAMEL_ASSIGN_OR_RETURN(const bool known, cohort.Bind(row.cohort).Any());
  if (known) return Status::Ok();
  return Status(Code::kNotFound, "no cohort " + row.cohort.Text(), "cohort_id");
}

Status PutStations(Db& db, const AssignmentRow& row) {
  {
    Query q(db, "DELETE FROM assignment_stations WHERE tenant = ?1 AND assignment = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(row.id).Run());
  }
  for (const Uuid& station : row.stations) {
    Query q(db,
            "INSERT INTO assignment_stations (tenant, assignment, station) "
            "SELECT ?1, ?2, id FROM stations WHERE tenant = ?1 AND id = ?3 AND revoked = 0 "
            "ON CONFLICT DO NOTHING");
    ENAMEL_RETURN_IF_ERROR(q.Bind(row.id, station).Run());
    // Nothing changes too where the list names a station twice.
    if (db.Changes() == 0 && std::ranges::count(row.stations, station) < 2) {
      return Status(Code::kNotFound,
                    "no admitted station " + station.Text() + "; revoked ones take no exams",
                    "station_ids");
    }
  }
  return Status::Ok();
}

// A ticket that was handed back has left nothing to release.
Status NoAttemptMustDependOn(Db& db, const Uuid& assignment) {
  Query q(db, "SELECT count(*) FROM attempts WHERE tenant = ?1 AND assignment = ?2 AND flags & " +
                  Sql(kReturned) + " = 0");
  ENAMEL_ASSIGN_OR_RETURN(const int64_t attempts, q.Bind(assignment).Value<int64_t>());
  if (attempts == 0) return Status::Ok();
  return Status(Code::kConflict,
                std::to_string(attempts) + (attempts == 1 ? " attempt was" : " attempts were") +
                    " made under this assignment, and their scores are released through it; to "
                    "end it, let it be due now",
                "attempts");
}

Status InsertAssignment(Db& db, const AssignmentRow& row) {
  ENAMEL_RETURN_IF_ERROR(Insert(
      db, "assignments", "id", row.id, "exercise_name", row.exercise, "cohort", row.cohort,
      "opens_ms", row.opens_ms, "due_ms", row.due_ms, "attempt_limit", row.attempt_limit, "exam",
      row.exam, "late_allowed", row.late_allowed, "revision", row.revision, "created_ms",
      row.created_ms, "hands", row.hands, "exercise", row.version_id, "counting",
      CountingName(row.counting), "sign_off", row.sign_off, "outline",
      OutlineShownName(row.outline),
      " ON CONFLICT (tenant, id) DO UPDATE SET exercise_name = excluded.exercise_name, cohort = "
      "excluded.cohort, opens_ms = excluded.opens_ms, due_ms = excluded.due_ms, attempt_limit = "
      "excluded.attempt_limit, exam = excluded.exam, late_allowed = excluded.late_allowed, "
      "revision = excluded.revision, hands = excluded.hands, exercise = excluded.exercise, "
      "counting = excluded.counting, sign_off = excluded.sign_off, outline = "
      "excluded.outline"));
  return PutStations(db, row);
}

Result<std::vector<AssignmentRow>> WithStations(Db& db, std::vector<AssignmentRow> rows) {
  for (AssignmentRow& row : rows) ENAMEL_RETURN_IF_ERROR(AddStations(db, row));
  return rows;
}

}  // namespace

Status NoteAssignment(Db& db, const Uuid& id, const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(const auto row, FindAssignment(db, id));
  return WriteAudit(db, by, "assignment.add", id.Text(), "{}", TermsJson(row));
}

Result<AssignmentRow> AssignmentRows::AddAssignment(const AssignmentRow& assignment,
                                                    const Actor& by) {
  AssignmentRow row = assignment;
  row.id = Uuid::New();
  row.revision = 1;
  row.created_ms = NowMs();
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(TakeNewestVersion(db, row));
    ENAMEL_RETURN_IF_ERROR(CohortMustBeKnown(db, row));
    ENAMEL_RETURN_IF_ERROR(InsertAssignment(db, row));
    return WriteAudit(db, by, "assignment.add", row.id.Text(), "{}", TermsJson(row));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return AssignmentById(row.id);
}

Result<AssignmentRow> AssignmentRows::ReplaceAssignment(const AssignmentRow& assignment,
                                                        const Actor& by) {
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto stored, FindAssignment(db, assignment.id));
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(stored.revision, assignment.revision));
    AssignmentRow row = assignment;
    row.version_id = stored.version_id;
    row.version = stored.version;
    // Other terms are no other work: the version stays.
    if (row.exercise != stored.exercise) ENAMEL_RETURN_IF_ERROR(TakeNewestVersion(db, row));
    ENAMEL_RETURN_IF_ERROR(CohortMustBeKnown(db, row));
    ++row.revision;
    ENAMEL_RETURN_IF_ERROR(InsertAssignment(db, row));
    return WriteAudit(db, by, "assignment.edit", row.id.Text(), TermsJson(stored), TermsJson(row));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return AssignmentById(assignment.id);
}

Result<AssignmentMove> AssignmentRows::MoveAssignment(const Uuid& id, const Uuid& version,
                                                      int32_t revision, bool look_only,
                                                      const Actor& by) {
  AssignmentMove move;
  auto find = [&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(move.before, FindAssignment(db, id));
    auto to = FindExercise(db, version);
    if (!to.ok() && to.status().code() != Code::kNotFound) return to.status();
    if (!to.ok() || to->name != move.before.exercise || to->state != ExerciseState::kPublished) {
      return Status(Code::kInvalidInput,
                    "expected a published version of \"" + move.before.exercise + "\", found " +
                        version.Text(),
                    "exercise_id");
    }
    ENAMEL_RETURN_IF_ERROR(NoExamMustBeOpen(db, move.before.exercise, id));
    move.after = move.before;
    move.after.version_id = to->id;
    move.after.version = to->version;
    move.after.title = to->title;
    move.after.graded = to->graded;
    move.after.retired = false;
    Query q(db,
            "SELECT count(*), coalesce(sum(CASE WHEN state = " + Sql(AttemptState::kTicketed) +
                " THEN 1 ELSE 0 END), 0) FROM attempts WHERE tenant = ?1 AND assignment = ?2 AND "
                "exercise <> ?3 AND flags & " +
                Sql(kReturned) + " = 0");
    q.Bind(id, version).Next();
    ENAMEL_RETURN_IF_ERROR(q.status());
    move.attempts = static_cast<uint32_t>(q.Int(0));
    move.tickets = static_cast<uint32_t>(q.Int(1));
    return Status::Ok();
  };
  if (look_only) {
    return rows_.Read([&](Db& db) -> Result<AssignmentMove> {
      ENAMEL_RETURN_IF_ERROR(find(db));
      return move;
    });
  }
  Status status = rows_.Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(find(db));
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(move.before.revision, revision));
    if (move.after.version_id == move.before.version_id) return Status::Ok();
    ++move.after.revision;
    Query q(db,
            "UPDATE assignments SET exercise = ?3, revision = ?4 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id, move.after.version_id, move.after.revision).Run());
    return WriteAudit(db, by, "assignment.move", id.Text(), TermsJson(move.before),
                      TermsJson(move.after));
  });
  ENAMEL_RETURN_IF_ERROR(status);
  return move;
}

Status AssignmentRows::DeleteAssignment(const Uuid& id, int32_t revision, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto stored, FindAssignment(db, id));
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(stored.revision, revision));
    ENAMEL_RETURN_IF_ERROR(NoAttemptMustDependOn(db, id));
    Query q(db, "DELETE FROM assignments WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id).Run());
    return WriteAudit(db, by, "assignment.delete", id.Text(), TermsJson(stored), "{}");
  });
}

Result<AssignmentRow> AssignmentRows::AssignmentById(const Uuid& id) {
  return rows_.Read([&](Db& db) { return FindAssignment(db, id); });
}

Result<std::vector<AssignmentRow>> AssignmentRows::Assignments(const AssignmentFilter& filter) {
  return rows_.Read([&](Db& db) -> Result<std::vector<AssignmentRow>> {
    std::vector<AssignmentRow> out;
    {
      std::string sql =
          "SELECT " ENAMEL_ASSIGNMENT_COLUMNS " FROM " ENAMEL_ASSIGNMENTS " WHERE a.tenant = ?1";
      std::vector<Uuid> ids;
      auto place = [&](const Uuid& id) {
        ids.push_back(id);
        return "?" + std::to_string(ids.size() + 1);
      };
      const Uuid everybody;
      if (filter.cohort) {
        sql += " AND a.cohort IN (" + place(*filter.cohort);
        sql += (filter.or_everybody ? ", " + place(everybody) : "") + ")";
      }
      if (filter.of_instructor) {
        sql += " AND (a.cohort = " + place(everybody);
        sql +=
            " OR a.cohort IN (SELECT m.cohort FROM cohort_members m WHERE m.tenant = ?1 AND "
            "m.person = " +
            place(*filter.of_instructor) + "))";
      }
      Query q(db, sql + " ORDER BY a.due_ms = 0, a.due_ms, a.id");
      for (const Uuid& id : ids) q.Bind(id);
      while (q.Next()) out.push_back(AssignmentOf(q));
      ENAMEL_RETURN_IF_ERROR(q.status());
    }
    return WithStations(db, std::move(out));
  });
}

Result<std::vector<AssignedRow>> AssignmentRows::AssignmentsFor(const Uuid& person) {
  return rows_.Read([&](Db& db) -> Result<std::vector<AssignedRow>> {
    std::vector<AssignedRow> out;
    {
      Query q(db,
              "SELECT " ENAMEL_ASSIGNMENT_COLUMNS
              ", (SELECT count(*) FROM attempts t WHERE t.tenant = ?1 AND t.assignment = a.id "
              "AND t.person = ?2 AND t.flags & " +
                  Sql(kExcused | kReturned) +
                  " = 0), " ENAMEL_EXERCISE_COLUMNS " FROM " ENAMEL_ASSIGNMENTS
                  " JOIN exercises e ON e.tenant = a.tenant AND e.id = a.exercise AND e.state <> " +
                  Sql(ExerciseState::kDraft) +
                  " " ENAMEL_EXERCISE_OWNERS
                  "WHERE a.tenant = ?1 AND (a.cohort = "
                  "?3 OR a.cohort IN (SELECT m.cohort FROM cohort_members m JOIN cohorts c ON "
                  "c.tenant = m.tenant AND c.id = m.cohort AND c.archived_ms = 0 WHERE m.tenant "
                  "= ?1 AND m.person = ?2)) ORDER BY a.exam DESC, a.due_ms = 0, a.due_ms, "
                  "a.exercise_name, a.id");
      q.Bind(person, Uuid{});
      while (q.Next()) {
        AssignedRow& row = out.emplace_back(AssignedRow{AssignmentOf(q), {}});
        q.Read(kAssignmentColumns, row.attempts_used, row.exercise);
      }
      ENAMEL_RETURN_IF_ERROR(q.status());
    }
    for (AssignedRow& row : out) ENAMEL_RETURN_IF_ERROR(AddStations(db, row.assignment));
    return out;
  });
}

namespace {

// Refuses while another station records an attempt of this person.
Status MustBeNowhereElse(Db& db, const AttemptRow& row) {
  Query q(db,
          "SELECT s.name FROM attempts a JOIN stations s ON s.tenant = a.tenant AND s.id = "
          "a.station WHERE a.tenant = ?1 AND a.person = ?2 AND a.station <> ?3 AND a.state = " +
              Sql(AttemptState::kRecording) +
              " AND (a.last_chunk_ms >= ?4 OR (a.last_chunk_ms = 0 AND a.ticketed_ms >= ?4)) AND "
              "a.flags & " +
              Sql(kExcused | kReturned) + " = 0 LIMIT 1");
  q.Bind(row.person, row.station, row.ticketed_ms - kElsewhereMs);
  const bool elsewhere = q.Next();
  ENAMEL_RETURN_IF_ERROR(q.status());
  if (!elsewhere) return Status::Ok();
  return Status(Code::kForbidden,
                "station \"" + q.Text(0) +
                    "\" is recording an attempt of yours; finish it there, wait a minute, and "
                    "begin again here",
                "station");
}

}  // namespace

// Checks the limit and other exams while making the attempt: two stations at once cannot both have
// the last one. A ticket that ran out with nothing begun is no exam under way.
Status MayBeIssued(Db& db, const AttemptRow& row) {
  if (!row.assignment || (row.flags & kReadmitted) != 0) return Status::Ok();
  Query q(
      db,
      "SELECT (SELECT attempt_limit FROM assignments WHERE tenant = ?1 AND id = ?2), (SELECT "
      "count(*) FROM attempts WHERE tenant = ?1 AND assignment = ?2 AND person = ?3 AND flags & " +
          Sql(kExcused | kReturned) +
          " = 0), (SELECT id FROM attempts WHERE tenant = ?1 AND person = ?3 AND exam = 1 AND "
          "(state = " +
          Sql(AttemptState::kRecording) + " OR (state = " + Sql(AttemptState::kTicketed) +
          " AND ticketed_ms >= ?4)) AND flags & " + Sql(kExcused | kReturned) + " = 0 LIMIT 1)");
  q.Bind(*row.assignment, row.person, row.ticketed_ms - kExamTicketValidMs).Next();
  ENAMEL_RETURN_IF_ERROR(q.status());
  int64_t limit = q.Int(0), used = q.Int(1);
  if (limit > 0 && used >= limit) {
    return Status(Code::kForbidden,
                  "the attempt limit of " + std::to_string(limit) +
                      " is used up; an instructor can excuse an attempt so that it does not count",
                  "attempt_limit");
  }
  if (row.exam && !q.IsNull(2)) {
    return Status(Code::kForbidden,
                  "exam attempt " + q.Id(2).Text() +
                      " is not finished; finish it, or ask an instructor to excuse it",
                  "exam");
  }
  return MustBeNowhereElse(db, row);
}

}  // namespace enamel::server
