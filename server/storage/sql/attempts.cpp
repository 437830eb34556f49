#include <algorithm>

#include "server/storage/sql/sql_names.h"
#include "server/storage/sql/sqlite_impl.h"

// Attempts as rows, and what scoring leaves. Their traces: traces.cpp.
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

// Of the newest run and the one before it all is kept, so that the newest can be taken back; of
// earlier ones the score and its reasons.
Status ForgetOldPictures(Db& db, const Uuid& attempt) {
  Query q(
      db,
      "UPDATE attempt_results SET final_volume = NULL, surface = NULL, series = NULL WHERE tenant "
      "= ?1 AND attempt = ?2 AND run < (SELECT max(n.run) - 1 FROM attempt_results n WHERE "
      "n.tenant = ?1 AND n.attempt = ?2)");
  return q.Bind(attempt).Run();
}

// Every run is kept: a score that was released and then changed can be explained.
Status KeepResult(Db& db, const Uuid& attempt, const Store::AttemptResult& result,
                  const Uuid& lease) {
  Query q(
      db,
      "INSERT INTO attempt_results (tenant, attempt, run, scored_ms, cause, score, "
      "critical_fail, score_json, reference, replay_realtime_factor, document, final_volume, "
      "surface, "
      "series) SELECT ?1, ?2, 1 + (SELECT coalesce(max(run), 0) FROM attempt_results WHERE tenant "
      "= "
      "?1 AND attempt = ?2), ?3, coalesce((SELECT cause FROM jobs WHERE tenant = ?1 AND lease = "
      "?8), "
      "'seal'), ?4, ?5, ?6, ?7, ?9, ?10, ?11, ?12, ?13");
  q.Bind(attempt)
      .Bind(result.scored_ms != 0 ? result.scored_ms : NowMs())
      .Bind(result.score)
      .Bind(int64_t{result.critical_fail});
  q.Bind(result.score_json).Bind(result.reference);
  q.Bind(lease).Bind(result.replay_realtime_factor).Bind(result.document);
  q.Bind(result.final_volume).Bind(result.surface).Bind(result.series);
  ENAMEL_RETURN_IF_ERROR(q.Run());
  return ForgetOldPictures(db, attempt);
}

// What RestoreResult takes over. Whether its run may be taken: only the newest but one has kept all
// that belongs to it.
struct KeptRun {
  int64_t newest = 0;
  Store::AttemptResult result;
};

Result<KeptRun> FindKept(Db& db, const Uuid& attempt, int32_t run) {
  Query q(db,
          "SELECT score, critical_fail, score_json, final_volume, surface, series, reference, "
          "scored_ms, document, (SELECT max(n.run) FROM attempt_results n WHERE n.tenant = ?1 AND "
          "n.attempt = ?2) FROM attempt_results WHERE tenant = ?1 AND attempt = ?2 AND run = ?3");
  if (!q.Bind(attempt).Bind(int64_t{run}).Next()) {
    if (!q.status().ok()) return q.status();
    return Status(Code::kNotFound,
                  "attempt " + attempt.Text() + " has no scoring run " + std::to_string(run),
                  "run");
  }
  KeptRun out;
  out.newest = q.Int(9);
  out.result.score = q.Real(0);
  out.result.critical_fail = q.Int(1) != 0;
  out.result.score_json = q.Hash(2);
  out.result.final_volume = q.Hash(3);
  out.result.surface = q.Hash(4);
  out.result.series = q.Hash(5);
  if (!q.IsNull(6)) out.result.reference = q.Id(6);
  out.result.scored_ms = q.Int(7);
  out.result.document = q.Blob(8);
  if (run == out.newest || !q.IsNull(4)) return out;
  return Status(Code::kConflict,
                "of run " + std::to_string(run) +
                    " only points and reasons are kept, as it is neither the newest nor the one "
                    "before; have the attempt scored again, or override its score",
                "run");
}

// The same run once more, so that the newest one stays the one that counts.
Status RepeatRun(Db& db, const Uuid& attempt, int32_t run) {
  Query q(
      db,
      "INSERT INTO attempt_results (tenant, attempt, run, scored_ms, cause, score, critical_fail, "
      "score_json, reference, replay_realtime_factor, document, final_volume, surface, series) "
      "SELECT tenant, attempt, (SELECT 1 + max(n.run) FROM attempt_results n WHERE n.tenant = ?1 "
      "AND n.attempt = ?2), scored_ms, 'restore', score, critical_fail, score_json, reference, "
      "replay_realtime_factor, document, final_volume, surface, series FROM attempt_results "
      "WHERE tenant = ?1 AND attempt = ?2 AND run = ?3");
  ENAMEL_RETURN_IF_ERROR(q.Bind(attempt).Bind(int64_t{run}).Run());
  return ForgetOldPictures(db, attempt);
}

// The row of an attempt as its newest run left it.
Status SetResult(Db& db, const Uuid& attempt, const Store::AttemptResult& result) {
  Query q(db, "UPDATE attempts SET state = " + Sql(AttemptState::kScored) +
                  ", progress = 1, problem = '', score = ?3, critical_fail = ?4, score_json = ?5, "
                  "final_volume = ?6, surface = ?7, series = ?8, reference = ?9 "
                  "WHERE tenant = ?1 AND id = ?2 AND state IN (" +
                  Sql(AttemptState::kSealed) + ", " + Sql(AttemptState::kScoring) + ", " +
                  Sql(AttemptState::kScored) + ", " + Sql(AttemptState::kFailed) + ")");
  q.Bind(attempt).Bind(result.score).Bind(static_cast<int64_t>(result.critical_fail));
  q.Bind(result.score_json).Bind(result.final_volume).Bind(result.surface).Bind(result.series);
  ENAMEL_RETURN_IF_ERROR(q.Bind(result.reference).Run());
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

Result<Json> ScoredJson(Db& db, const Uuid& attempt, const Sha256& score_json, ByteView document) {
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
          "SELECT content, others, nearest_um, median_um, size_um FROM motions WHERE tenant = ?1 "
          "AND attempt = ?2");
  if (q.Bind(attempt).Next()) {
    motion = q.Hash(0).Hex();
    for (int i = 1; i < 5; ++i) motion += " " + std::to_string(q.Int(i));
  }
  ENAMEL_RETURN_IF_ERROR(q.status());
  return JsonOf({{"score_json", score_json.Hex()},
                 {"result", HashSha256(document).Hex()},
                 {"cause", cause},
                 {"motion", motion}});
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
  if (!nobody) return status;
  ENAMEL_ASSIGN_OR_RETURN(const bool gone, keyring_.IsGone(row.person));
  if (!gone) return status;
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
                                  const Uuid& lease) {
  return Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeRunning(db, lease));
    ENAMEL_RETURN_IF_ERROR(WithdrawReleaseOfAnotherScore(db, attempt, result));
    ENAMEL_RETURN_IF_ERROR(RaiseRevisionForAnother(db, attempt, result));
    ENAMEL_RETURN_IF_ERROR(SetResult(db, attempt, result));
    ENAMEL_RETURN_IF_ERROR(KeepResult(db, attempt, result, lease));
    ENAMEL_RETURN_IF_ERROR(WaitForTimeline(db, attempt));
    ENAMEL_RETURN_IF_ERROR(KeepMotion(db, attempt, result));
    ENAMEL_RETURN_IF_ERROR(blobs_.Hold(db, {result.score_json, result.final_volume, result.surface,
                                            result.series, result.motion}));
    ENAMEL_ASSIGN_OR_RETURN(const auto scored,
                            ScoredJson(db, attempt, result.score_json, result.document));
    ENAMEL_RETURN_IF_ERROR(FinishRun(db, lease));
    return WriteAudit(db, Actor{{}, "job"}, kAuditScore, attempt.Text(), "{}", scored);
  });
}

Status SqliteStore::RestoreResult(const Uuid& attempt, int32_t run, const Actor& by,
                                  std::optional<int32_t> revision) {
  return Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto row, FindAttempt(db, attempt));
    if (revision) ENAMEL_RETURN_IF_ERROR(MustBeRevision(row.revision, *revision));
    if (row.expired_ms != 0) {
      return Status(Code::kConflict,
                    "the recording of attempt " + attempt.Text() +
                        " was removed by a retention rule; its score stays as it is");
    }
    ENAMEL_ASSIGN_OR_RETURN(const auto kept, FindKept(db, attempt, run));
    ENAMEL_RETURN_IF_ERROR(CancelRunsOf(db, attempt, by));
    // It counts already; what was to take its place is cancelled.
    if (run == kept.newest) return Status::Ok();
    ENAMEL_RETURN_IF_ERROR(WithdrawReleaseOfAnotherScore(db, attempt, kept.result));
    ENAMEL_RETURN_IF_ERROR(RaiseRevisionForAnother(db, attempt, kept.result));
    ENAMEL_RETURN_IF_ERROR(SetResult(db, attempt, kept.result));
    ENAMEL_RETURN_IF_ERROR(RepeatRun(db, attempt, run));
    ENAMEL_ASSIGN_OR_RETURN(const auto scored,
                            ScoredJson(db, attempt, kept.result.score_json, kept.result.document));
    return WriteAudit(db, by, kAuditRestore, attempt.Text(),
                      JsonOf({{"run", std::to_string(kept.newest)}}), scored);
  });
}

// An earlier score counts again: a run that fails takes nothing away that somebody has seen.
Status SqliteStore::FailAttempt(const Uuid& attempt, const std::string& problem,
                                const Uuid& lease) {
  return Write([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeRunning(db, lease));
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

// By the run and not by the attempt: one that was cancelled must not move the next one's bar.
Status SqliteStore::SetProgress(const Uuid& lease, double progress) {
  return WriteRow([&](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(MustBeRunning(db, lease));
    Query q(db, "UPDATE attempts SET progress = ?3 WHERE tenant = ?1 AND state = " +
                    Sql(AttemptState::kScoring) +
                    " AND id = (SELECT "
                    "attempt FROM jobs WHERE tenant = ?1 AND lease = ?2)");
    return q.Bind(lease).Bind(std::clamp(progress, 0.0, 1.0)).Run();
  });
}

}  // namespace enamel::server::sqlite
