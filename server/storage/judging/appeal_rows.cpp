#include "server/storage/judging/appeal_rows.h"

#include <optional>
#include <string>

#include "server/storage/attempts/attempt_rows.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/row_checks.h"
#include "server/storage/judging/judging_rows.h"

// Appeals.
namespace enamel::server {
Status AppealRows::FileAppeal(const Uuid& attempt, const std::string& text, const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto row, FindAttempt(db, attempt));
    // Before that the student does not know the score, and it may still change.
    if (!row.released) {
      return Status(Code::kConflict,
                    "the score of attempt " + attempt.Text() +
                        " is not released; there is nothing to appeal against yet");
    }
    ENAMEL_RETURN_IF_ERROR(Explain(Insert(db, "appeals", "attempt", attempt, "filed_ms", NowMs(),
                                          "text", text, "state", "open"),
                                   "an appeal against this attempt was filed before; there is one "
                                   "per attempt"));
    return WriteAudit(db, by, "appeal.file", attempt.Text(), "{}", JsonOf({{"text", text}}));
  });
}

Status AppealRows::AnswerAppeal(const Uuid& attempt, bool regrade, const std::string& answer,
                                const Actor& by) {
  return rows_.Write([&](Db& db) -> Status {
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
      ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, outcome, answer, by.person, NowMs()).Run());
    }
    // A regrade is a run by the same rules; what an instructor thinks of it is an override.
    if (regrade) ENAMEL_RETURN_IF_ERROR(QueueAgain(db, attempt, "appeal"));
    return WriteAudit(db, by, "appeal.answer", attempt.Text(), JsonOf({{"state", state}}),
                      JsonOf({{"state", outcome}, {"answer", answer}}));
  });
}

Result<std::optional<AppealRow>> AppealRows::AppealOf(const Uuid& attempt) {
  return rows_.Read([&](Db& db) -> Result<std::optional<AppealRow>> {
    Query q(db,
            "SELECT attempt, filed_ms, text, state, answer, answered_by, answered_ms FROM appeals "
            "WHERE tenant = ?1 AND attempt = ?2");
    return q.Bind(attempt).Maybe<AppealRow>();
  });
}

}  // namespace enamel::server
