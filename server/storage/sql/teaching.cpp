#include <algorithm>

#include "server/storage/sql/decisions.h"
#include "server/storage/sql/sql_names.h"
#include "server/storage/sql/sqlite_impl.h"

// What people say about an attempt: release, override, annotations, appeals; and scoring it again.
namespace enamel::server::sqlite {
namespace {

#define ENAMEL_ANNOTATION_SELECT                                                             \
  "SELECT n.id, n.attempt, n.author, coalesce(p.display_name, ''), n.tick, n.x_um, n.y_um, " \
  "n.z_um, n.text, n.created_ms, n.edited_ms, n.revision, n.to_chair, "                      \
  "coalesce(n.remark_id, 0) FROM annotations n "                                             \
  "LEFT JOIN people p ON p.tenant = n.tenant AND p.id = n.author WHERE n.tenant = ?1"

AnnotationRow AnnotationOf(const Query& q) {
  AnnotationRow out;
  out.id = q.Id(0);
  out.attempt = q.Id(1);
  out.author = q.Id(2);
  out.author_name = q.Text(3);
  out.tick = static_cast<uint64_t>(q.Int(4));
  if (!q.IsNull(5)) {
    out.point_um = {static_cast<int32_t>(q.Int(5)), static_cast<int32_t>(q.Int(6)),
                    static_cast<int32_t>(q.Int(7))};
  }
  out.text = q.Text(8);
  out.created_ms = q.Int(9);
  out.edited_ms = q.Int(10);
  out.revision = static_cast<int32_t>(q.Int(11));
  out.to_chair = q.Int(12) != 0;
  out.remark_id = static_cast<uint64_t>(q.Int(13));
  return out;
}

Result<AnnotationRow> FindAnnotation(Db& db, const Uuid& id) {
  Query q(db, ENAMEL_ANNOTATION_SELECT " AND n.id = ?2");
  if (q.Bind(id).Next()) return AnnotationOf(q);
  if (!q.status().ok()) return q.status();
  return Status(Code::kNotFound, "no annotation " + id.Text());
}

// Binds ?3 and on: tick, point, text.
Query& BindRemark(Query& q, const AnnotationRow& row) {
  q.Bind(static_cast<int64_t>(row.tick));
  for (size_t axis = 0; axis < 3; ++axis) {
    if (row.point_um) {
      q.Bind(int64_t{(*row.point_um)[axis]});
    } else {
      q.BindNull(sql::Type::kInt);
    }
  }
  return q.Bind(row.text);
}

Status SendToChair(Db& db, const AnnotationRow& row, int64_t now_ms) {
  Query last(db,
             "SELECT coalesce(max(remark_id), 0) FROM annotations WHERE tenant = ?1 AND attempt = "
             "?2");
  const int64_t before = last.Bind(row.attempt).Next() ? last.Int(0) : 0;
  ENAMEL_RETURN_IF_ERROR(last.status());
  Query q(db,
          "UPDATE annotations SET remark_id = ?3, remark_state = 'waiting' WHERE tenant = ?1 AND "
          "id = ?2");
  // Time, so that one is not taken for an earlier one that was deleted.
  return q.Bind(row.id).Bind(std::max({now_ms, before + 1, int64_t{1}})).Run();
}

Json RemarkJson(const AnnotationRow& row) {
  return JsonOf(
      {{"annotation", row.id.Text()}, {"tick", std::to_string(row.tick)}, {"text", row.text}});
}

Json OverrideJson(const std::optional<ScoreOverride>& score) {
  if (!score) return "{}";
  return JsonOf({{"score", std::to_string(score->score)}, {"reason", score->reason}});
}

// The attempt as the caller has seen it.
// No revision: whoever asks has not shown the attempt to anybody.
Result<AttemptRow> FindSeen(Db& db, const Uuid& attempt, std::optional<int32_t> revision) {
  auto row = FindAttempt(db, attempt);
  if (row.ok() && revision) {
    if (Status same = MustBeRevision(row->revision, *revision); !same.ok()) return same;
  }
  return row;
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
  // It will see what was changed; a second one would only repeat it.
  if (q.Int(1) != 0) {
    return Status(Code::kConflict, "a scoring run of this attempt is waiting or under way already");
  }
  // Asking for a score is how an instructor lets a quarantined attempt in.
  if (row.state == AttemptState::kQuarantined) {
    Query accept(db, "UPDATE attempts SET state = " + Sql(AttemptState::kSealed) +
                         ", problem = '' WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(accept.Bind(attempt).Run());
  }
  return QueueScoreJob(db, attempt, cause);
}

}  // namespace

// Scores and flags change in several places and each raises it, so that no edit overwrites what
// its author has not seen.
Status RaiseRevision(Db& db, const Uuid& attempt) {
  Query q(db, "UPDATE attempts SET revision = revision + 1 WHERE tenant = ?1 AND id = ?2");
  return q.Bind(attempt).Run();
}

Status SetFlags(Db& db, const Uuid& attempt, uint32_t flags, const std::string& reason,
                const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(auto row, FindAttempt(db, attempt));
  if ((row.flags & flags) == flags) return Status::Ok();
  Query q(db, "UPDATE attempts SET flags = flags | ?3 WHERE tenant = ?1 AND id = ?2");
  ENAMEL_RETURN_IF_ERROR(q.Bind(attempt).Bind(int64_t{flags}).Run());
  ENAMEL_RETURN_IF_ERROR(RaiseRevision(db, attempt));
  std::string names;
  for (const char* name : AttemptFlagNames(flags))
    names += (names.empty() ? "" : " ") + std::string(name);
  return WriteAudit(db, by, "attempt.flag", attempt.Text(), "{}",
                    JsonOf({{"flags", names}, {"reason", reason}}));
}

// The revision rises: an override that was begun before the release was seen is refused.
Status SetReleased(Db& db, const Uuid& attempt, bool released, const Actor& by) {
  ENAMEL_RETURN_IF_ERROR(RaiseRevision(db, attempt));
  Query q(db, "UPDATE attempts SET released = ?3 WHERE tenant = ?1 AND id = ?2");
  ENAMEL_RETURN_IF_ERROR(q.Bind(attempt).Bind(int64_t{released}).Run());
  return WriteAudit(db, by, released ? "attempt.release" : "attempt.unrelease", attempt.Text(),
                    JsonOf({{"released", released ? "no" : "yes"}}),
                    JsonOf({{"released", released ? "yes" : "no"}}));
}

Status SqliteStore::ReleaseAttempt(const Uuid& attempt, const Actor& by,
                                   std::optional<int32_t> revision) {
  return Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindSeen(db, attempt, revision));
    if (row.state != AttemptState::kScored) {
      return Status(Code::kConflict, "attempt " + attempt.Text() + " is " +
                                         AttemptStateName(row.state) +
                                         ", only a scored one can be released");
    }
    return row.released ? Status::Ok() : SetReleased(db, attempt, true, by);
  });
}

Status SqliteStore::WithdrawRelease(const Uuid& attempt, const Actor& by,
                                    std::optional<int32_t> revision) {
  return Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindSeen(db, attempt, revision));
    return row.released ? SetReleased(db, attempt, false, by) : Status::Ok();
  });
}

Status SqliteStore::OverrideScore(const Uuid& attempt, const std::optional<ScoreOverride>& score,
                                  const Actor& by, std::optional<int32_t> revision) {
  return Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindSeen(db, attempt, revision));
    // An override stands beside the score and its reasons, it does not take their place.
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
      q.Bind(attempt);
      if (score) {
        q.Bind(score->score).Bind(score->reason).Bind(by.person).Bind(NowMs());
      } else {
        q.BindNull(sql::Type::kReal)
            .Bind(std::string())
            .BindNull(sql::Type::kBlob)
            .Bind(int64_t{0});
      }
      ENAMEL_RETURN_IF_ERROR(q.Run());
    }
    ENAMEL_RETURN_IF_ERROR(RaiseRevision(db, attempt));
    return WriteAudit(db, by, "attempt.override", attempt.Text(), OverrideJson(row.overridden),
                      OverrideJson(score));
  });
}

Status SqliteStore::FlagAttempt(const Uuid& attempt, uint32_t flags, const std::string& reason,
                                const Actor& by, std::optional<int32_t> revision) {
  return Write([&](Db& db) -> Status {
    auto row = FindSeen(db, attempt, revision);
    if (!row.ok()) return row.status();
    return SetFlags(db, attempt, flags, reason, by);
  });
}

Status SqliteStore::ClearExcuse(const Uuid& attempt, const Actor& by,
                                std::optional<int32_t> revision) {
  return Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto row, FindSeen(db, attempt, revision));
    if ((row.flags & kExcused) == 0) return Status::Ok();
    {
      Query q(db, "UPDATE attempts SET flags = flags - ?3 WHERE tenant = ?1 AND id = ?2");
      ENAMEL_RETURN_IF_ERROR(q.Bind(attempt).Bind(int64_t{kExcused}).Run());
    }
    ENAMEL_RETURN_IF_ERROR(RaiseRevision(db, attempt));
    return WriteAudit(db, by, "attempt.unflag", attempt.Text(), JsonOf({{"flags", "excused"}}),
                      "{}");
  });
}

Status SqliteStore::Rescore(const Uuid& attempt, const std::string& cause, const Actor& by) {
  ENAMEL_RETURN_IF_ERROR(AcceptCommitted(attempt, by));
  return Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindAttempt(db, attempt));
    ENAMEL_RETURN_IF_ERROR(QueueAgain(db, attempt, cause));
    return WriteAudit(db, by, "attempt.rescore", attempt.Text(),
                      JsonOf({{"state", AttemptStateName(row.state)}, {"problem", row.problem}}),
                      JsonOf({{"cause", cause}}));
  });
}

Result<std::vector<ResultRow>> SqliteStore::ResultsOf(const Uuid& attempt) {
  return Read([&](Db& db) -> Result<std::vector<ResultRow>> {
    Query q(db,
            "SELECT run, scored_ms, cause, score, critical_fail, score_json, reference, "
            "replay_realtime_factor, document, surface IS NOT NULL FROM attempt_results WHERE "
            "tenant = ?1 AND attempt = "
            "?2 ORDER "
            "BY run DESC");
    q.Bind(attempt);
    std::vector<ResultRow> out;
    while (q.Next()) {
      ResultRow row;
      row.run = static_cast<int32_t>(q.Int(0));
      row.scored_ms = q.Int(1);
      row.cause = q.Text(2);
      row.score = q.Real(3);
      row.critical_fail = q.Int(4) != 0;
      row.score_json = q.Hash(5);
      if (!q.IsNull(6)) row.reference = q.Id(6);
      row.replay_realtime_factor = q.Real(7);
      row.document = q.Blob(8);
      row.is_whole = q.Int(9) != 0;
      out.push_back(std::move(row));
    }
    if (!q.status().ok()) return q.status();
    return out;
  });
}

Result<AnnotationRow> SqliteStore::AddAnnotation(const AnnotationRow& annotation, const Actor& by) {
  AnnotationRow row = annotation;
  row.id = Uuid::New();
  Status status = Write([&](Db& db) -> Status {
    if (auto attempt = FindAttempt(db, row.attempt); !attempt.ok()) return attempt.status();
    const int64_t now_ms = NowMs();
    Query q(db,
            "INSERT INTO annotations (tenant, id, tick, x_um, y_um, z_um, text, attempt, author, "
            "created_ms, to_chair) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)");
    BindRemark(q.Bind(row.id), row).Bind(row.attempt).Bind(by.person).Bind(now_ms);
    q.Bind(int64_t{row.to_chair});
    ENAMEL_RETURN_IF_ERROR(q.Run());
    if (row.to_chair) ENAMEL_RETURN_IF_ERROR(SendToChair(db, row, now_ms));
    return WriteAuditAbout(db, SubjectOf("annotation", row.id.Text()), by, "annotation.add",
                           row.attempt.Text(), "{}", RemarkJson(row));
  });
  if (!status.ok()) return status;
  return AnnotationById(row.id);
}

Result<AnnotationRow> SqliteStore::ReplaceAnnotation(const AnnotationRow& row, const Actor& by) {
  Status status = Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto stored, FindAnnotation(db, row.id));
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(stored.revision, row.revision));
    Query q(
        db,
        "UPDATE annotations SET tick = ?3, x_um = ?4, y_um = ?5, z_um = ?6, text = ?7, edited_ms "
        "= ?8, revision = revision + 1 WHERE tenant = ?1 AND id = ?2");
    BindRemark(q.Bind(row.id), row).Bind(NowMs());
    ENAMEL_RETURN_IF_ERROR(q.Run());
    return WriteAuditAbout(db, SubjectOf("annotation", stored.id.Text()), by, "annotation.edit",
                           stored.attempt.Text(), RemarkJson(stored), RemarkJson(row));
  });
  if (!status.ok()) return status;
  return AnnotationById(row.id);
}

Status SqliteStore::DeleteAnnotation(const Uuid& id, int32_t revision, const Actor& by) {
  return Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto stored, FindAnnotation(db, id));
    ENAMEL_RETURN_IF_ERROR(MustBeRevision(stored.revision, revision));
    Query q(db, "DELETE FROM annotations WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(id).Run());
    return WriteAuditAbout(db, SubjectOf("annotation", stored.id.Text()), by, "annotation.delete",
                           stored.attempt.Text(), RemarkJson(stored), "{}");
  });
}

Result<AnnotationRow> SqliteStore::AnnotationById(const Uuid& id) {
  return Read([&](Db& db) { return FindAnnotation(db, id); });
}

Result<std::vector<AnnotationRow>> SqliteStore::AnnotationsOf(const Uuid& attempt) {
  return Read([&](Db& db) -> Result<std::vector<AnnotationRow>> {
    Query q(db, ENAMEL_ANNOTATION_SELECT " AND n.attempt = ?2 ORDER BY n.tick, n.id");
    q.Bind(attempt);
    std::vector<AnnotationRow> out;
    while (q.Next()) out.push_back(AnnotationOf(q));
    if (!q.status().ok()) return q.status();
    return out;
  });
}

Status SqliteStore::FileAppeal(const Uuid& attempt, const std::string& text, const Actor& by) {
  return Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindAttempt(db, attempt));
    // Before that the student does not know the score, and it may still change.
    if (!row.released) {
      return Status(Code::kConflict,
                    "the score of attempt " + attempt.Text() +
                        " is not released; there is nothing to appeal against yet");
    }
    Query q(db,
            "INSERT INTO appeals (tenant, attempt, filed_ms, text, state) VALUES (?1, ?2, ?3, ?4, "
            "'open')");
    ENAMEL_RETURN_IF_ERROR(Explain(q.Bind(attempt).Bind(NowMs()).Bind(text).Run(),
                                   "an appeal against this attempt was filed before; there is one "
                                   "per attempt"));
    return WriteAudit(db, by, "appeal.file", attempt.Text(), "{}", JsonOf({{"text", text}}));
  });
}

Status SqliteStore::AnswerAppeal(const Uuid& attempt, bool regrade, const std::string& answer,
                                 const Actor& by) {
  return Write([&](Db& db) -> Status {
    std::string state;
    {
      Query q(db, "SELECT state FROM appeals WHERE tenant = ?1 AND attempt = ?2");
      if (!q.Bind(attempt).Next()) {
        ENAMEL_RETURN_IF_ERROR(q.status());
        return Status(Code::kNotFound, "no appeal against attempt " + attempt.Text());
      }
      state = q.Text(0);
    }
    if (state != "open") {
      return Status(Code::kConflict, "this appeal was answered before: " + state);
    }
    std::string outcome = regrade ? "regraded" : "rejected";
    {
      Query q(db,
              "UPDATE appeals SET state = ?3, answer = ?4, answered_by = ?5, answered_ms = ?6 "
              "WHERE tenant = ?1 AND attempt = ?2");
      q.Bind(attempt).Bind(outcome).Bind(answer).Bind(by.person).Bind(NowMs());
      ENAMEL_RETURN_IF_ERROR(q.Run());
    }
    // A regrade is a run by the same rules; what an instructor thinks of it is an override.
    if (regrade) ENAMEL_RETURN_IF_ERROR(QueueAgain(db, attempt, "appeal"));
    return WriteAudit(db, by, "appeal.answer", attempt.Text(), JsonOf({{"state", state}}),
                      JsonOf({{"state", outcome}, {"answer", answer}}));
  });
}

Result<std::optional<AppealRow>> SqliteStore::AppealOf(const Uuid& attempt) {
  return Read([&](Db& db) -> Result<std::optional<AppealRow>> {
    Query q(db,
            "SELECT attempt, filed_ms, text, state, answer, answered_by, answered_ms FROM appeals "
            "WHERE tenant = ?1 AND attempt = ?2");
    std::optional<AppealRow> out;
    if (q.Bind(attempt).Next()) {
      out = AppealRow{q.Id(0), q.Int(1), q.Text(2), q.Text(3), q.Text(4), q.Id(5), q.Int(6)};
    }
    if (!q.status().ok()) return q.status();
    return out;
  });
}

}  // namespace enamel::server::sqlite
