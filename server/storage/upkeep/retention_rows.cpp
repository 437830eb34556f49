#include "server/storage/upkeep/retention_rows.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <set>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/sql_names.h"
#include "server/storage/judging/motion_rows.h"
#include "server/storage/judging/timeline_rows.h"
#include "server/storage/recordings/trace_parts.h"
#include "server/storage/upkeep/deletion.h"

// Rules that say how long things are kept.
namespace enamel::server {
namespace {

// A blob that no row names is a leftover of a crash or a repeated scoring; a younger one may be
// about to be named.
constexpr std::chrono::hours kUnnamedFor{24};
constexpr int64_t kDayMs = 24ll * 60 * 60 * 1000;
constexpr int32_t kMaxDays = 36'500;
constexpr int32_t kMinUnfinishedDays = 14;
// A station may offer its recordings for a week. If one were removed earlier, it would be taken in
// again as if a restore had forgotten it.
constexpr int32_t kMinAttemptsDays = 8;

struct Rule {
  const char* what;
  int32_t min_days;
  std::string condition;  // ?2: before when
};
// A sealed one without a job is a leftover of a cancelled run.
std::string IsComplete() {
  return "a.state IN (" + Sql(AttemptState::kSealed) + ", " + Sql(AttemptState::kScored) + ", " +
         Sql(AttemptState::kFailed) + ")";
}
const std::array<Rule, 3>& Rules() {
  static const std::array<Rule, 3> kRules{{
      {"unfinished", kMinUnfinishedDays,
       "a.state IN (" + Sql(AttemptState::kTicketed) + ", " + Sql(AttemptState::kRecording) +
           ") AND a.ticketed_ms < ?2"},
      {"recordings", 1,
       IsComplete() + " AND a.expired_ms = 0 AND a.sealed_ms > 0 AND a.sealed_ms < ?2"},
      {"attempts", kMinAttemptsDays,
       "(" + IsComplete() + " AND a.sealed_ms > 0 AND a.sealed_ms < ?2) OR (a.state = " +
           Sql(AttemptState::kQuarantined) + " AND a.ticketed_ms < ?2)"},
  }};
  return kRules;
}
// Never removed: references, and recordings that a job may be reading.
constexpr const char* kNotInUse =
    " AND NOT EXISTS (SELECT 1 FROM reference_cuts r WHERE r.tenant = a.tenant AND r.attempt = "
    "a.id) AND NOT EXISTS (SELECT 1 FROM jobs j WHERE j.tenant = a.tenant AND j.attempt = a.id AND "
    "j.state IN ('queued', 'running'))";

// What somebody still has to decide about: an appeal without an answer, and a student's graded work
// that is neither released nor excused (IsReleasedFirst in server/training/access.h; a test
// compares the two).
std::string Held() {
  return "(EXISTS (SELECT 1 FROM appeals o WHERE o.tenant = a.tenant AND o.attempt = a.id AND "
         "o.state = 'open') OR (" +
         IsComplete() + " AND a.released = 0 AND a.as_reference = 0 AND a.flags & " +
         Sql(kExcused) + " = 0 AND (a.exam = 1 OR (a.flags & " + Sql(kReadmitted) +
         " <> 0 AND a.assignment IS NULL) OR EXISTS (SELECT 1 FROM exercises e WHERE e.tenant = "
         "a.tenant AND e.id = a.exercise AND e.graded = 1)) AND EXISTS (SELECT 1 FROM people p "
         "WHERE p.tenant = a.tenant AND p.id = a.person AND p.role = " +
         Sql(Role::kStudent) + ")))";
}

// By stored name: a rule unknown to this program has no row, because SetRetention refuses it.
const Rule* FindRule(const std::string& what) {
  auto found = std::ranges::find(Rules(), what, &Rule::what);
  return found == Rules().end() ? nullptr : &*found;
}

Result<std::vector<RetentionRule>> RulesIn(Db& db) {
  Query q(db, "SELECT what, days FROM retention_rules WHERE tenant = ?1 ORDER BY what");
  return q.All<RetentionRule>();
}

std::vector<Uuid>& ListOf(RetentionReport& report, const std::string& what) {
  if (what == "unfinished") return report.unfinished;
  return what == "recordings" ? report.recordings : report.attempts;
}

Status FindDue(Db& db, UnixMs now_ms, RetentionReport& report) {
  ENAMEL_ASSIGN_OR_RETURN(auto rules, RulesIn(db));
  std::set<Uuid> held;
  for (const RetentionRule& row : rules) {
    const Rule* rule = FindRule(row.what);
    ENAMEL_CHECK(rule != nullptr);
    std::string sql = "SELECT a.id, " + Held() + " FROM attempts a WHERE a.tenant = ?1 AND (" +
                      rule->condition + ")" + kNotInUse + " ORDER BY a.id";
    Query q(db, sql);
    q.Bind(now_ms - int64_t{std::max(row.days, rule->min_days)} * kDayMs);
    while (q.Next()) {
      if (q.Int(1) != 0) {
        held.insert(q.Id(0));
      } else {
        ListOf(report, row.what).push_back(q.Id(0));
      }
    }
    ENAMEL_RETURN_IF_ERROR(q.status());
  }
  report.held = held.size();
  // What goes as a whole needs no step before.
  std::erase_if(report.recordings,
                [&](const Uuid& id) { return std::ranges::binary_search(report.attempts, id); });
  return Status::Ok();
}

// The recording and what shows motion go; score and reasons stay.
Status Expire(Db& db, const std::vector<Uuid>& attempts, UnixMs now_ms, std::set<Sha256>& blobs) {
  for (const Uuid& attempt : attempts) {
    Query named(
        db,
        "SELECT trace_blob, final_volume, deviation, series FROM attempts WHERE tenant = ?1 "
        "AND id = ?2");
    if (named.Bind(attempt).Next()) {
      for (int i = 0; i < 4; ++i) {
        if (Sha256 hash = named.Hash(i); !hash.IsZero()) blobs.insert(hash);
      }
    }
    ENAMEL_RETURN_IF_ERROR(named.status());
    Query runs(db,
               "SELECT final_volume, deviation, series FROM attempt_results WHERE tenant = ?1 AND "
               "attempt = ?2");
    for (runs.Bind(attempt); runs.Next();) {
      for (int i = 0; i < 3; ++i) {
        if (Sha256 hash = runs.Hash(i); !hash.IsZero()) blobs.insert(hash);
      }
    }
    ENAMEL_RETURN_IF_ERROR(runs.status());
    ENAMEL_RETURN_IF_ERROR(DropParts(db, attempt, blobs));
    ENAMEL_RETURN_IF_ERROR(DropTimeline(db, attempt, blobs));
    ENAMEL_RETURN_IF_ERROR(DropMotion(db, attempt, blobs));
    for (const char* sql :
         {"UPDATE attempt_results SET final_volume = NULL, deviation = NULL, series = NULL WHERE "
          "tenant "
          "= ?1 AND attempt = ?2",
          "DELETE FROM trace_chunks WHERE tenant = ?1 AND attempt = ?2",
          "DELETE FROM contradicting_chunks WHERE tenant = ?1 AND attempt = ?2"}) {
      ENAMEL_RETURN_IF_ERROR(Query(db, sql).Bind(attempt).Run());
    }
    Query q(
        db,
        "UPDATE attempts SET expired_ms = ?3, trace_blob = NULL, final_volume = NULL, deviation = "
        "NULL, series = NULL WHERE tenant = ?1 AND id = ?2");
    ENAMEL_RETURN_IF_ERROR(q.Bind(attempt, now_ms).Run());
  }
  return Status::Ok();
}

// Found again in the writing transaction: an appeal may have come in since the list was shown.
Status Remove(Db& db, UnixMs now_ms, const Actor& by, RetentionReport& report,
              std::set<Sha256>& blobs) {
  report = {};
  blobs.clear();
  ENAMEL_RETURN_IF_ERROR(FindDue(db, now_ms, report));
  ENAMEL_RETURN_IF_ERROR(Expire(db, report.recordings, now_ms, blobs));
  ENAMEL_RETURN_IF_ERROR(DeleteAttempts(db, report.unfinished, blobs));
  ENAMEL_RETURN_IF_ERROR(DeleteAttempts(db, report.attempts, blobs));
  for (const Rule& rule : Rules()) {
    for (const Uuid& attempt : ListOf(report, rule.what)) {
      ENAMEL_RETURN_IF_ERROR(WriteAudit(db, by, "attempt.retention", attempt.Text(), "{}",
                                        JsonOf({{"rule", rule.what}})));
    }
  }
  return Status::Ok();
}

}  // namespace

Result<std::vector<RetentionRule>> RetentionRows::RetentionRules() {
  return rows_.Read([](Db& db) { return RulesIn(db); });
}

Status RetentionRows::SetRetention(const RetentionRule& rule, const Actor& by) {
  const Rule* known = FindRule(rule.what);
  if (known == nullptr) {
    return Status(
        Code::kInvalidInput,
        "expected a rule for unfinished, recordings or attempts, found \"" + rule.what + "\"",
        "what");
  }
  if (rule.days != 0 && (rule.days < known->min_days || rule.days > kMaxDays)) {
    return Status(Code::kInvalidInput,
                  "expected " + std::to_string(known->min_days) + " to " +
                      std::to_string(kMaxDays) + " days for " + rule.what +
                      ", or 0 for no rule, found " + std::to_string(rule.days),
                  "days");
  }
  // 0 days is no rule, and a missing rule has no row.
  return rows_.Write([&](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(auto rules, RulesIn(db));
    auto old = std::ranges::find(rules, rule.what, &RetentionRule::what);
    int32_t before = old == rules.end() ? 0 : old->days;
    if (before == rule.days) return Status::Ok();
    {
      Query q(db, "DELETE FROM retention_rules WHERE tenant = ?1 AND what = ?2");
      ENAMEL_RETURN_IF_ERROR(q.Bind(rule.what).Run());
    }
    if (rule.days != 0) {
      ENAMEL_RETURN_IF_ERROR(Insert(db, "retention_rules", "what", rule.what, "days", rule.days));
    }
    return WriteAudit(db, by, "retention.set", rule.what,
                      JsonOf({{"days", std::to_string(before)}}),
                      JsonOf({{"days", std::to_string(rule.days)}}));
  });
}

Result<RetentionReport> RetentionRows::ApplyRetention(UnixMs now_ms, bool dry_run,
                                                      const Actor& by) {
  RetentionReport report;
  ENAMEL_RETURN_IF_ERROR(rows_
                             .Read([&](Db& db) -> Result<bool> {
                               ENAMEL_RETURN_IF_ERROR(FindDue(db, now_ms, report));
                               return true;
                             })
                             .status());
  if (dry_run) return report;
  ENAMEL_ASSIGN_OR_RETURN(auto alone, rewriter_.TakeUpkeep());
  std::vector<Blobs::Freed> freed;
  bool anything =
      !report.unfinished.empty() || !report.recordings.empty() || !report.attempts.empty();
  if (anything) {
    const Status deleted = rows_.Write([&](Db& db) -> Status {
      std::set<Sha256> blobs;
      ENAMEL_RETURN_IF_ERROR(Remove(db, now_ms, by, report, blobs));
      ENAMEL_ASSIGN_OR_RETURN(freed, blobs_.Free(db, blobs));
      return Status::Ok();
    });
    ENAMEL_RETURN_IF_ERROR(deleted);
  }
  ENAMEL_ASSIGN_OR_RETURN(auto removed, blobs_.Remove(freed));
  ENAMEL_ASSIGN_OR_RETURN(auto swept, blobs_.Sweep(kUnnamedFor));
  report.blobs = removed + swept;
  if (rows_.shared()) ENAMEL_RETURN_IF_ERROR(sign_ins_.Sweep());
  // Last, because the rules free space; a failure is in the log and left for the next time.
  (void)rewriter_.RunIfMarked();
  return report;
}

}  // namespace enamel::server
