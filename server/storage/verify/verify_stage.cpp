#include "server/storage/verify/verify_stage.h"

#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"

namespace enamel::server {
namespace {

struct Stage {
  Uuid attempt;
  AttemptState state = AttemptState::kTicketed;
  bool has_header = false, has_recording = false, has_score = false;
  bool run_is_under_way = false, run_failed = false, run_waits = false;  // waits, or was cancelled
};

// A recording that a retention rule removed counts as present.
constexpr char kStages[] =
    "SELECT a.id, a.state, a.header IS NOT NULL, (a.trace_blob IS NOT NULL OR a.expired_ms <> 0), "
    "a.score IS NOT NULL, EXISTS (SELECT 1 FROM jobs j WHERE j.tenant = a.tenant AND j.attempt = "
    "a.id AND j.state = 'running'), EXISTS (SELECT 1 FROM jobs j WHERE j.tenant = a.tenant AND "
    "j.attempt = a.id AND j.state = 'failed'), EXISTS (SELECT 1 FROM jobs j WHERE j.tenant = "
    "a.tenant AND j.attempt = a.id AND j.state IN ('queued', 'cancelled')) FROM attempts a WHERE "
    "a.tenant = ?1";

// Why the stage cannot be this one; empty: it can.
std::string WhyNot(const Stage& stage) {
  switch (stage.state) {
    case AttemptState::kTicketed:
      return stage.has_header || stage.has_recording ? "it was begun" : "";
    case AttemptState::kRecording:
      if (!stage.has_header) return "it was not begun";
      return stage.has_recording ? "its recording is sealed" : "";
    case AttemptState::kSealed:
      if (!stage.has_recording) return "its recording is not sealed";
      if (stage.has_score) return "it has a score";
      if (stage.run_is_under_way) return "a run is under way";
      return stage.run_failed && !stage.run_waits ? "a run has failed and none waits" : "";
    case AttemptState::kScoring:
      if (!stage.has_recording) return "its recording is not sealed";
      return stage.run_is_under_way ? "" : "no run is under way";
    case AttemptState::kScored:
      return stage.has_score ? "" : "it has no score";
    case AttemptState::kFailed:
      if (stage.has_score) return "it has a score";
      return stage.run_failed ? "" : "no run has failed";
    case AttemptState::kQuarantined:
      return stage.has_header ? "" : "it was not begun";
  }
  return "there is no such state";
}

// A run that failed by its recording ends as done; its row in the trail says that it failed.
Result<bool> TrailTellsOfFailure(Db& db, const Uuid& attempt) {
  Query q(db, "SELECT 1 FROM audit WHERE tenant = ?1 AND object = ?2 AND action = 'attempt.fail'");
  return q.Bind(attempt.Text()).Any();
}

}  // namespace

Status CheckStages(Db& db, VerifyReport& report) {
  Query q(db, kStages);
  while (q.Next()) {
    Stage stage = q.Row<Stage>();
    const bool ended = stage.state == AttemptState::kFailed || stage.state == AttemptState::kSealed;
    if (ended && !stage.has_score && !stage.run_failed) {
      ENAMEL_ASSIGN_OR_RETURN(stage.run_failed, TrailTellsOfFailure(db, stage.attempt));
    }
    const std::string why = WhyNot(stage);
    if (why.empty()) continue;
    report.findings.push_back(
        {"decision", stage.attempt.Text(), "attempt: state another one, as " + why,
         "state " + std::string(AttemptStateName(stage.state)),
         "look in a backup for what it was; compare the audit trail's rows about this attempt"});
  }
  return q.status();
}

}  // namespace enamel::server
