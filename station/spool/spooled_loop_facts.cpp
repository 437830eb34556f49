#include "station/spool/spooled_loop_facts.h"

#include "station/spool/attempt_row.h"
#include "station/spool/spool_file.h"

namespace enamel::station {

Status SpooledLoopFacts::Put(const Uuid& attempt, const KeptLoopFacts& facts) {
  MutexLock lock(file_.mutex());
  sql::Query s(
      file_.db(),
      // From the attempt's own row, so that facts of a missing attempt are not kept. Replaces: for
      // a run that ended twice (a full disk, then room) the last end counts.
      "INSERT OR REPLACE INTO loop_facts (attempt, run, ended_unix_ms, facts)"
      " SELECT id, ?2, ?3, ?4 FROM attempts WHERE id = ?1");
  s.BindBlob(attempt.view()).BindInt(facts.run).BindInt(facts.ended_unix_ms).BindText(facts.json);
  ENAMEL_RETURN_IF_ERROR(file_.Run(s, "storing how the loop went"));
  return file_.db().Changes() == 1 ? Status::Ok() : NoAttempt(attempt);
}

Result<std::vector<KeptLoopFacts>> SpooledLoopFacts::Of(const Uuid& attempt) {
  MutexLock lock(file_.mutex());
  sql::Query s(file_.db(),
               "SELECT run, ended_unix_ms, facts FROM loop_facts WHERE attempt = ? ORDER BY run");
  s.BindBlob(attempt.view());
  std::vector<KeptLoopFacts> out;
  while (s.Next()) {
    out.push_back({static_cast<uint32_t>(s.Int(0)), s.Int(1), s.Text(2)});
  }
  if (!s.status().ok()) return file_.Fail("reading how loops went");
  return out;
}

}  // namespace enamel::station
