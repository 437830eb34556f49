#include "station/spool/spooled_loop_facts.h"

#include "station/spool/attempt_row.h"
#include "station/spool/spool_file.h"
#include "station/spool/statement.h"

namespace enamel::station {

Status SpooledLoopFacts::Put(const Uuid& attempt, const KeptLoopFacts& facts) {
  std::lock_guard lock(file_.mutex());
  Statement s(
      file_.handle(),
      // From the attempt's own row, so that facts of one that is not there are not kept. Replaced:
      // a run that ended twice (a full disk, then room) is told by its last end.
      "INSERT OR REPLACE INTO loop_facts (attempt, run, ended_unix_ms, facts)"
      " SELECT id, ?2, ?3, ?4 FROM attempts WHERE id = ?1");
  s.Blob(attempt.view()).Int(facts.run).Int(facts.ended_unix_ms).Text(facts.json);
  if (s.Step() != SQLITE_DONE) return file_.Fail("storing how the loop went");
  return sqlite3_changes(file_.handle()) == 1 ? Status::Ok() : NoAttempt(attempt);
}

Result<std::vector<KeptLoopFacts>> SpooledLoopFacts::Of(const Uuid& attempt) {
  std::lock_guard lock(file_.mutex());
  Statement s(file_.handle(),
              "SELECT run, ended_unix_ms, facts FROM loop_facts WHERE attempt = ? ORDER BY run");
  s.Blob(attempt.view());
  std::vector<KeptLoopFacts> out;
  int rc = 0;
  while ((rc = s.Step()) == SQLITE_ROW) {
    out.push_back({static_cast<uint32_t>(s.IntAt(0)), s.IntAt(1), s.TextAt(2)});
  }
  if (rc != SQLITE_DONE) return file_.Fail("reading how loops went");
  return out;
}

}  // namespace enamel::station
