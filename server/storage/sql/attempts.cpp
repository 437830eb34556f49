#include <algorithm>

#include "server/storage/sql/sql_names.h"
#include "server/storage/sql/sqlite_impl.h"

// Attempts as rows, what scoring leaves, references. Their traces: traces.cpp.
namespace enamel::server::sqlite {
namespace {

constexpr char kAttemptSelect[] =
    "SELECT a.id, a.person, p.display_name, a.station, a.exercise, e.title, e.content, "
    "a.profile_content, "
    "a.state, a.as_reference, a.released, a.ticketed_ms, a.sealed_ms, a.chunks, a.ticks, "
    "a.gap_ticks, "
    "a.trace_bytes, a.score, a.critical_fail, a.progress, a.problem, a.expired_ms, a.assignment, "
    "a.exam, a.due_ms, a.rate_hz, a.limit_ticks, a.flags, a.last_chunk_ms, a.override_score, "
    "a.override_reason, a.override_by, a.override_ms, a.revision, a.facts, a.hands, "
    "a.hand_kind, a.hand_device, a.hand_driver, a.hand_unit FROM attempts a "
    "JOIN people p ON p.tenant = a.tenant AND p.id = a.person "
    "JOIN exercises e ON e.tenant = a.tenant AND e.id = a.exercise WHERE a.tenant = ?1";

AttemptRow AttemptOf(const Query& q) {
  AttemptRow out;
  out.id = q.Id(0);
  out.person = q.Id(1);
  out.person_name = q.Text(2);
  out.station = q.Id(3);
  out.exercise = q.Id(4);
  out.exercise_title = q.Text(5);
  out.exercise_content = q.Hash(6);
  out.profile_content = q.Hash(7);
  out.state = static_cast<AttemptState>(q.Int(8));
  out.as_reference = q.Int(9) != 0;
  out.released = q.Int(10) != 0;
  out.ticketed_ms = q.Int(11);
  out.sealed_ms = q.Int(12);
  out.chunks = static_cast<uint32_t>(q.Int(13));
  out.ticks = static_cast<uint64_t>(q.Int(14));
  out.gap_ticks = static_cast<uint64_t>(q.Int(15));
  out.trace_bytes = static_cast<uint64_t>(q.Int(16));
  if (!q.IsNull(17)) out.score = q.Real(17);
  out.critical_fail = q.Int(18) != 0;
  out.progress = q.Real(19);
  out.problem = q.Text(20);
  out.expired_ms = q.Int(21);
  if (!q.IsNull(22)) out.assignment = q.Id(22);
  out.exam = q.Int(23) != 0;
  out.due_ms = q.Int(24);
  out.rate_hz = static_cast<int32_t>(q.Int(25));
  out.limit_ticks = static_cast<uint64_t>(q.Int(26));
  out.flags = static_cast<uint32_t>(q.Int(27));
  out.last_chunk_ms = q.Int(28);
  if (!q.IsNull(29)) out.overridden = ScoreOverride{q.Real(29), q.Text(30), q.Id(31), q.Int(32)};
  out.revision = static_cast<int32_t>(q.Int(33));
  out.facts = q.Text(34);
  out.hands = static_cast<HandsAllowed>(q.Int(35));
  out.hand = {static_cast<HandKind>(q.Int(36)), q.Text(37), q.Text(38), q.Text(39)};
  return out;
}

// An UPDATE that finds no row is no failure of SQL.
Status MustExist(Db& db, const Uuid& attempt) {
  if (db.Changes() > 0) return Status::Ok();
  return Status(Code::kNotFound, "no attempt " + attempt.Text());
}

// Those too whose run is under way: it may have looked for a reference before this one was there.
Status QueueUnreferenced(Db& db, const Uuid& exercise) {
  std::vector<Uuid> waiting;
  {
    Query q(
        db,
        "SELECT a.id FROM attempts a WHERE a.tenant = ?1 AND a.exercise = ?2 AND a.state IN (" +
            Sql(AttemptState::kSealed) + ", " + Sql(AttemptState::kScoring) + ", " +
            Sql(AttemptState::kScored) + ", " + Sql(AttemptState::kFailed) +
            ") AND a.reference IS NULL AND a.expired_ms = 0 AND NOT EXISTS (SELECT 1 "
            "FROM jobs j WHERE j.tenant = a.tenant AND j.attempt = a.id AND j.state = 'queued')");
    q.Bind(exercise);
    while (q.Next()) waiting.push_back(q.Id(0));
    ENAMEL_RETURN_IF_ERROR(q.status());
  }
  for (const Uuid& attempt : waiting) {
    ENAMEL_RETURN_IF_ERROR(QueueScoreJob(db, attempt, "reference"));
  }
  return Status::Ok();
}

Status InsertReference(Db& db, ReferenceRow& row) {
  {
    Query q(
        db,
        "SELECT coalesce(max(version), 0) FROM reference_cuts WHERE tenant = ?1 AND exercise = ?2");
    // Counted in the writing transaction, so that no two get the same.
    row.version = q.Bind(row.exercise).Next() ? static_cast<int32_t>(q.Int(0)) + 1 : 1;
    ENAMEL_RETURN_IF_ERROR(q.status());
  }
  Query q(
      db,
      "INSERT INTO reference_cuts (tenant, id, exercise, attempt, dentist, version, created_ms, "
      "consent) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)");
  q.Bind(row.id).Bind(row.exercise).Bind(row.attempt).Bind(row.dentist).Bind(int64_t{row.version});
  return q.Bind(row.created_ms).Bind(int64_t{row.consent}).Run();
}

#define ENAMEL_REFERENCE_SELECT                                                             \
  "SELECT id, exercise, attempt, dentist, version, created_ms, consent, withdrawn_ms FROM " \
  "reference_cuts WHERE tenant = ?1"

ReferenceRow ReferenceOf(const Query& q) {
  return ReferenceRow{q.Id(0),  q.Id(1),       q.Id(2), q.Text(3), static_cast<int32_t>(q.Int(4)),
                      q.Int(5), q.Int(6) != 0, q.Int(7)};
}

// A cut that does not do the task would make everybody's score 0.
Status MustDoTheTask(const AttemptRow& attempt) {
  if (!attempt.critical_fail && attempt.score.value_or(0) > 0) return Status::Ok();
  return Status(
      Code::kConflict,
      "attempt " + attempt.id.Text() +
          " scored 0: what does not do the task cannot be the reference for others; if the "
          "reference it was compared with is wrong, withdraw that and score it again",
      "score");
}

// Said again, by another dentist's name perhaps: it counts once, as it was said last.
Status WithdrawEarlier(Db& db, const Uuid& attempt) {
  Query q(db,
          "UPDATE reference_cuts SET withdrawn_ms = ?3 WHERE tenant = ?1 AND attempt = ?2 AND "
          "withdrawn_ms = 0");
  return q.Bind(attempt).Bind(NowMs()).Run();
}

Result<ReferenceRow> FindReference(Db& db, const Uuid& id) {
  Query q(db, ENAMEL_REFERENCE_SELECT " AND id = ?2");
  if (q.Bind(id).Next()) return ReferenceOf(q);
  if (!q.status().ok()) return q.status();
  return Status(Code::kNotFound, "no reference " + id.Text());
}

// A run that was cancelled may still come to its end, also after another one was queued.
Status MustBeRunning(Db& db, const Uuid& job) {
  if (job.IsZero()) return Status::Ok();
  Query q(db, "SELECT state FROM jobs WHERE tenant = ?1 AND id = ?2");
  std::string state = q.Bind(job).Next() ? q.Text(0) : "gone";
  ENAMEL_RETURN_IF_ERROR(q.status());
  if (state == "running") return Status::Ok();
  return Status(Code::kUnavailable, state == "cancelled"
                                        ? "this scoring run was cancelled"
                                        : "this scoring run is over: its job is " + state);
}

// Whether the row has another score than the run's, unless it is the one that the run found to have
// the same points and reasons: that it still is, is seen in the transaction, as another run may have
// ended meanwhile.
constexpr char kIsAnother[] =
    "(score IS DISTINCT FROM ?3 OR critical_fail IS DISTINCT FROM ?4 OR score_json IS DISTINCT "
    "FROM ?5) AND score_json IS DISTINCT FROM ?6";

void BindAnother(Query& q, const Store::AttemptResult& result) {
  q.Bind(result.score).Bind(int64_t{result.critical_fail}).Bind(result.score_json);
  if (result.same_judgement_as) {
    q.Bind(*result.same_judgement_as);
  } else {
    q.BindNull(sql::Type::kBlob);
  }
}

// A released score that turns out otherwise is not yet one that an instructor has seen: of graded
// work and exams it is released anew.
Status WithdrawReleaseOfAnotherScore(Db& db, const Uuid& attempt,
                                     const Store::AttemptResult& result) {
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

// Every run is kept: a score that was released and then changed can be explained.
Status KeepResult(Db& db, const Uuid& attempt, const Store::AttemptResult& result,
                  const Uuid& job) {
  Query q(
      db,
      "INSERT INTO attempt_results (tenant, attempt, run, scored_ms, cause, score, "
      "critical_fail, score_json, reference, replay_realtime_factor, document) SELECT ?1, ?2, 1 + "
      "(SELECT "
      "coalesce(max(run), 0) "
      "FROM attempt_results WHERE tenant = ?1 AND attempt = ?2), ?3, coalesce((SELECT cause FROM "
      "jobs WHERE tenant = ?1 AND id = ?8), 'seal'), ?4, ?5, ?6, ?7, "
      "?9, ?10");
  q.Bind(attempt)
      .Bind(result.scored_ms != 0 ? result.scored_ms : NowMs())
      .Bind(result.score)
      .Bind(int64_t{result.critical_fail});
  q.Bind(result.score_json).Bind(result.reference);
  q.Bind(job).Bind(result.replay_realtime_factor);
  return (result.document.empty() ? q.BindNull(sql::Type::kBlob) : q.Bind(result.document)).Run();
}

Result<bool> Is(Db& db, const char* sql, const Uuid& id) {
  Query q(db, sql);
  bool there = q.Bind(id).Next();
  if (!q.status().ok()) return q.status();
  return there;
}

// Names what is not here: after a restore it may come back.
Status MustBeHere(Db& db, const AttemptRow& row) {
  const struct {
    const char* what;
    const char* sql;
    const Uuid& id;
  } things[] = {
      {"person", "SELECT 1 FROM people WHERE tenant = ?1 AND id = ?2", row.person},
      {"station", "SELECT 1 FROM stations WHERE tenant = ?1 AND id = ?2", row.station},
      {"exercise", "SELECT 1 FROM exercises WHERE tenant = ?1 AND id = ?2", row.exercise},
  };
  for (const auto& thing : things) {
    ENAMEL_ASSIGN_OR_RETURN(auto there, Is(db, thing.sql, thing.id));
    if (there) continue;
    std::string what = thing.what;
    return Status(Code::kNotFound, "there is no " + what + " " + thing.id.Text() + " here", what);
  }
  return Status::Ok();
}

// Another score than the one that was there.
Status RaiseRevisionForAnother(Db& db, const Uuid& attempt, const Store::AttemptResult& result) {
  Query q(db,
          std::string(
              "UPDATE attempts SET revision = revision + 1 WHERE tenant = ?1 AND id = ?2 AND ") +
              kIsAnother);
  BindAnother(q.Bind(attempt), result);
  return q.Run();
}

}  // namespace

Json ScoredJson(const Sha256& score_json, ByteView document) {
  if (document.empty()) return JsonOf({{"score_json", score_json.Hex()}});
  return JsonOf({{"score_json", score_json.Hex()}, {"result", HashSha256(document).Hex()}});
}

Result<AttemptRow> FindAttempt(Db& db, const Uuid& id) {
  static const std::string kSql = std::string(kAttemptSelect) + " AND a.id = ?2";
  Query q(db, kSql.c_str());
  if (q.Bind(id).Next()) return AttemptOf(q);
  if (!q.status().ok()) return q.status();
  return Status(Code::kNotFound, "no attempt " + id.Text());
}

Status SqliteStore::CreateAttempt(const AttemptRow& row, ByteView ticket, const Actor& by) {
  ENAMEL_RETURN_IF_ERROR(MayRecord());
  Status status = Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeHere(db, row));
    ENAMEL_RETURN_IF_ERROR(MayBeIssued(db, row));
    Query q(db,
            "INSERT INTO attempts (tenant, id, person, station, exercise, profile_content, state, "
            "as_reference, ticketed_ms, ticket, exam, due_ms, rate_hz, limit_ticks, flags, "
            "assignment, hands) VALUES (?1, ?2, ?3, ?4, ?5, ?6, " +
                Sql(AttemptState::kTicketed) +
                ", ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, "
                "?15, ?16)");
    q.Bind(row.id).Bind(row.person).Bind(row.station).Bind(row.exercise).Bind(row.profile_content);
    q.Bind(static_cast<int64_t>(row.as_reference)).Bind(row.ticketed_ms).Bind(ticket);
    q.Bind(int64_t{row.exam}).Bind(row.due_ms).Bind(int64_t{row.rate_hz});
    q.Bind(static_cast<int64_t>(row.limit_ticks)).Bind(int64_t{row.flags});
    q.Bind(row.assignment).Bind(static_cast<int64_t>(row.hands));
    ENAMEL_RETURN_IF_ERROR(Explain(q.Run(), "attempt " + row.id.Text() + " exists"));
    return WriteAudit(db, by, "attempt.ticket", row.id.Text(), "{}",
                      JsonOf({{"person", row.person.Text()},
                              {"exercise", row.exercise.Text()},
                              {"assignment", row.assignment ? row.assignment->Text() : ""},
                              {"exam", row.exam ? "yes" : "no"}}));
  });
  // Erased or never here: only the key ring knows, as the row is gone in both cases. A station that
  // was away may still offer what such a person recorded.
  bool nobody = status.code() == Code::kNotFound && status.field() == "person";
  if (!nobody || !keyring_.IsGone(row.person)) return status;
  return Status(Code::kConflict, "this person was erased; nothing of theirs is taken any more",
                "person");
}

// Twice is the same as once: the station tells it until it has an answer.
Status SqliteStore::ReturnTicket(const Uuid& attempt, const Actor& by) {
  return Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindAttempt(db, attempt));
    if ((row.flags & kReturned) != 0) return Status::Ok();
    // Otherwise handing back would be a way to try until it goes well.
    if (row.state != AttemptState::kTicketed) {
      return Status(Code::kConflict,
                    "attempt " + attempt.Text() +
                        " was begun, so its ticket is used up; an instructor can excuse the "
                        "attempt so that it does not count",
                    "attempt");
    }
    Query q(db, "UPDATE attempts SET flags = flags | ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt).Bind(int64_t{kReturned}).Run());
    return WriteAudit(db, by, "attempt.return", attempt.Text(),
                      JsonOf({{"state", AttemptStateName(row.state)}}),
                      JsonOf({{"returned", "yes"}}));
  });
}

Result<AttemptRow> SqliteStore::AttemptById(const Uuid& id) {
  return Read([&](Db& db) { return FindAttempt(db, id); });
}

Result<std::vector<AttemptRow>> SqliteStore::Attempts(const AttemptFilter& filter) {
  std::string sql = kAttemptSelect;
  std::vector<Uuid> ids;
  std::vector<int64_t> numbers;
  // ?1 is the tenant; all ids are bound before all numbers, so ids must be placed first.
  auto next = [&] { return "?" + std::to_string(ids.size() + numbers.size() + 1); };
  auto where = [&](const std::optional<Uuid>& id, const std::string& before,
                   const std::string& after) {
    if (!id) return;
    ids.push_back(*id);
    sql += " AND " + before + next() + after;
  };
  auto number = [&](int64_t value) {
    numbers.push_back(value);
    return next();
  };
  where(filter.person, "a.person = ", "");
  where(filter.cohort,
        "EXISTS (SELECT 1 FROM cohort_members m WHERE m.tenant = a.tenant AND m.person = a.person "
        "AND m.cohort = ",
        ")");
  where(filter.visible_to_instructor,
        "EXISTS (SELECT 1 FROM cohort_members i JOIN cohort_members m ON m.tenant = i.tenant AND "
        "m.cohort = i.cohort WHERE i.tenant = a.tenant AND m.person = a.person AND i.person = ",
        ")");
  where(filter.exercise, "a.exercise = ", "");
  where(filter.assignment, "a.assignment = ", "");
  // Ids rise with time: a list goes on where the last one ended, whatever came in meanwhile.
  where(filter.before, "a.id < ", "");
  if (filter.state) sql += " AND a.state = " + number(static_cast<int64_t>(*filter.state));
  if (filter.flags != 0) {
    std::string bits = number(filter.flags);
    sql += " AND a.flags & " + bits + " = " + bits;
  }
  if (filter.open_appeal) {
    sql +=
        " AND EXISTS (SELECT 1 FROM appeals o WHERE o.tenant = a.tenant AND o.attempt = a.id AND "
        "o.state = 'open')";
  }
  // The bound is ours, not the asker's.
  sql += " ORDER BY a.id DESC LIMIT " + number(std::clamp<uint32_t>(filter.limit, 1, 200));
  return Read([&](Db& db) -> Result<std::vector<AttemptRow>> {
    Query q(db, sql.c_str());
    for (const Uuid& id : ids) q.Bind(id);
    for (int64_t value : numbers) q.Bind(value);
    std::vector<AttemptRow> out;
    while (q.Next()) out.push_back(AttemptOf(q));
    if (!q.status().ok()) return q.status();
    return out;
  });
}

Status SqliteStore::FinishAttempt(const Uuid& attempt, const AttemptResult& result,
                                  const Uuid& job) {
  return Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeRunning(db, job));
    ENAMEL_RETURN_IF_ERROR(WithdrawReleaseOfAnotherScore(db, attempt, result));
    ENAMEL_RETURN_IF_ERROR(RaiseRevisionForAnother(db, attempt, result));
    Query q(db, "UPDATE attempts SET state = " + Sql(AttemptState::kScored) +
                    ", progress = 1, problem = '', score = ?3, critical_fail "
                    "= ?4, "
                    "score_json = ?5, final_volume = ?6, surface = ?7, series = ?8, "
                    "reference = ?9 "
                    "WHERE tenant = ?1 AND id = ?2 AND state IN (" +
                    Sql(AttemptState::kSealed) + ", " + Sql(AttemptState::kScoring) + ", " +
                    Sql(AttemptState::kScored) + ", " + Sql(AttemptState::kFailed) + ")");
    q.Bind(attempt).Bind(result.score).Bind(static_cast<int64_t>(result.critical_fail));
    q.Bind(result.score_json).Bind(result.final_volume).Bind(result.surface).Bind(result.series);
    q.Bind(result.reference);
    ENAMEL_RETURN_IF_ERROR(q.Run());
    if (db.Changes() == 0) {
      return Status(Code::kConflict,
                    "attempt " + attempt.Text() + " is not one that waits for a score");
    }
    ENAMEL_RETURN_IF_ERROR(KeepResult(db, attempt, result, job));
    ENAMEL_RETURN_IF_ERROR(WaitForTimeline(db, attempt));
    ENAMEL_RETURN_IF_ERROR(KeepMotion(db, attempt, result));
    return WriteAudit(db, Actor{{}, "job"}, "attempt.score", attempt.Text(), "{}",
                      ScoredJson(result.score_json, result.document));
  });
}

// An earlier score counts again: a run that fails takes nothing away that somebody has seen.
Status SqliteStore::FailAttempt(const Uuid& attempt, const std::string& problem, const Uuid& job) {
  return Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeRunning(db, job));
    Query q(db, "UPDATE attempts SET state = CASE WHEN score IS NULL THEN " +
                    Sql(AttemptState::kFailed) + " ELSE " + Sql(AttemptState::kScored) +
                    " END, problem = ?3, progress = "
                    "CASE WHEN score IS NULL THEN 0 ELSE 1 END WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt).Bind(problem).Run());
    ENAMEL_RETURN_IF_ERROR(MustExist(db, attempt));
    return WriteAudit(db, Actor{{}, "job"}, "attempt.fail", attempt.Text(), "{}",
                      JsonOf({{"problem", problem}}));
  });
}

Result<Store::AttemptResult> SqliteStore::ResultOf(const Uuid& attempt) {
  return Read([&](Db& db) -> Result<AttemptResult> {
    Query q(db,
            "SELECT a.score, a.critical_fail, a.score_json, a.final_volume, a.surface, a.series, "
            "a.reference, "
            "r.replay_realtime_factor, r.scored_ms, r.document FROM attempts a LEFT JOIN "
            "attempt_results r ON r.tenant = a.tenant AND r.attempt = a.id WHERE a.tenant = ?1 AND "
            "a.id = ?2 ORDER BY r.run DESC LIMIT 1");
    if (!q.Bind(attempt).Next()) {
      if (!q.status().ok()) return q.status();
      return Status(Code::kNotFound, "no attempt " + attempt.Text());
    }
    if (q.IsNull(2))
      return Status(Code::kConflict, "attempt " + attempt.Text() + " has no score yet");
    AttemptResult out;
    out.score = q.Real(0);
    out.critical_fail = q.Int(1) != 0;
    out.score_json = q.Hash(2);
    out.final_volume = q.Hash(3);
    out.surface = q.Hash(4);
    out.series = q.Hash(5);
    if (!q.IsNull(6)) out.reference = q.Id(6);
    out.replay_realtime_factor = q.Real(7);
    out.scored_ms = q.Int(8);
    out.document = q.Blob(9);
    return out;
  });
}

// By the job and not by the attempt: a run that was cancelled must not move the next one's bar.
Status SqliteStore::SetProgress(const Uuid& job, double progress) {
  return Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeRunning(db, job));
    Query q(db, "UPDATE attempts SET progress = ?3 WHERE tenant = ?1 AND state = " +
                    Sql(AttemptState::kScoring) +
                    " AND id = (SELECT "
                    "attempt FROM jobs WHERE tenant = ?1 AND id = ?2)");
    return q.Bind(job).Bind(std::clamp(progress, 0.0, 1.0)).Run();
  });
}

Result<ReferenceRow> SqliteStore::AddReference(const Uuid& attempt, const std::string& dentist,
                                               bool consent, const Actor& by) {
  ReferenceRow row;
  row.consent = consent;
  row.id = Uuid::New();
  row.attempt = attempt;
  row.dentist = dentist;
  row.created_ms = NowMs();
  Status status = Write([&](Db& db) -> Status {
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
    // What was scored without a reference is scored again with it; what was compared with an earlier
    // one keeps its score until somebody asks.
    ENAMEL_RETURN_IF_ERROR(QueueUnreferenced(db, row.exercise));
    return WriteAudit(
        db, by, "reference.add", attempt.Text(), "{}",
        JsonOf({{"exercise", row.exercise.Text()}, {"version", std::to_string(row.version)}}));
  });
  if (!status.ok()) return status;
  return row;
}

Result<std::optional<ReferenceRow>> SqliteStore::ReferenceFor(const Uuid& exercise) {
  return Read([&](Db& db) -> Result<std::optional<ReferenceRow>> {
    Query q(db, ENAMEL_REFERENCE_SELECT
            " AND exercise = ?2 AND withdrawn_ms = 0 ORDER BY version DESC LIMIT 1");
    std::optional<ReferenceRow> out;
    if (q.Bind(exercise).Next()) out = ReferenceOf(q);
    if (!q.status().ok()) return q.status();
    return out;
  });
}

Result<ReferenceRow> SqliteStore::ReferenceById(const Uuid& id) {
  return Read([&](Db& db) { return FindReference(db, id); });
}

Result<std::vector<ReferenceRow>> SqliteStore::References(const Uuid& exercise) {
  return Read([&](Db& db) -> Result<std::vector<ReferenceRow>> {
    Query q(db, ENAMEL_REFERENCE_SELECT " AND exercise = ?2 ORDER BY version DESC");
    q.Bind(exercise);
    std::vector<ReferenceRow> out;
    while (q.Next()) out.push_back(ReferenceOf(q));
    if (!q.status().ok()) return q.status();
    return out;
  });
}

// It is marked and not deleted: scores that were compared with it still name it.
Status SqliteStore::WithdrawReference(const Uuid& id, const Actor& by) {
  return Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindReference(db, id));
    if (row.withdrawn_ms != 0) return Status::Ok();
    Query q(db, "UPDATE reference_cuts SET withdrawn_ms = ?3 WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id).Bind(NowMs()).Run());
    return WriteAudit(
        db, by, "reference.withdraw", row.attempt.Text(),
        JsonOf({{"exercise", row.exercise.Text()}, {"version", std::to_string(row.version)}}),
        JsonOf({{"withdrawn", "yes"}}));
  });
}

}  // namespace enamel::server::sqlite
