#include "server/storage/verify/verify_results.h"

#include <map>

#include "server/results/result_document.h"
#include "server/storage/audit/decisions.h"
#include "server/storage/engine/query.h"
#include "server/storage/judging/result_rows.h"

namespace enamel::server {
namespace {

constexpr char kScoreAgain[] =
    "have the attempt scored again, which computes it from the recording and signs it; find out "
    "who changed it from the audit trail and a backup";

// A run with the present columns of the attempt's row.
struct Run {
  Uuid attempt;
  int64_t run = 0, newest = 0;
  UnixMs scored_ms = 0;
  double score = 0;
  bool critical_fail = false;
  std::string cause;
  Sha256 score_json, tooth, deviation, series;
  std::optional<Uuid> reference;
  Bytes document;

  // Of the attempt's row.
  double row_score = 0;
  bool row_critical_fail = false, expired = false;
  Sha256 row_score_json, row_tooth, row_deviation, row_series, recording, profile, exercise;
  std::optional<Uuid> row_reference;
  Bytes header;
  uint32_t flags = 0;
};

constexpr char kRuns[] =
    "SELECT r.attempt, r.run, (SELECT max(n.run) FROM attempt_results n WHERE n.tenant = r.tenant "
    "AND n.attempt = r.attempt), r.scored_ms, r.score, r.critical_fail, r.score_json, r.reference, "
    "r.document, a.score, a.critical_fail, a.score_json, a.final_volume, a.deviation, a.series, "
    "a.reference, a.head_hash, a.header, a.profile_content, e.content, a.flags, a.expired_ms, "
    "r.cause, r.final_volume, r.deviation, r.series FROM attempt_results r JOIN attempts a ON "
    "a.tenant = r.tenant AND "
    "a.id = r.attempt JOIN exercises e ON e.tenant = a.tenant AND e.id = a.exercise WHERE "
    "r.tenant = ?1 ORDER BY r.attempt, r.run";

Run RunOf(const Query& q) {
  Run out;
  q.Read(0, out.attempt, out.run, out.newest, out.scored_ms, out.score, out.critical_fail,
         out.score_json, out.reference, out.document, out.row_score, out.row_critical_fail,
         out.row_score_json, out.row_tooth, out.row_deviation, out.row_series, out.row_reference,
         out.recording, out.header, out.profile, out.exercise, out.flags, out.expired, out.cause,
         out.tooth, out.deviation, out.series);
  return out;
}

std::string TextOf(double points) { return std::to_string(points) + " points"; }
std::string TextOf(bool failed) { return failed ? "failed critically" : "not failed"; }
std::string TextOf(const Sha256& hash) { return hash.IsZero() ? "none" : hash.Hex(); }
std::string TextOf(const Uuid& id) { return id.IsZero() ? "none" : id.Text(); }
std::string TextOf(UnixMs ms) { return std::to_string(ms) + " ms"; }

class RunCheck {
 public:
  RunCheck(Db& db, const Run& run, const std::optional<trace::PublicKey>& key, VerifyReport& report)
      : db_(db), run_(run), key_(key), report_(report) {}

  Status Check() {
    // The run and the row of the attempt agree, signed or not.
    if (run_.run == run_.newest) {
      Same("points of the attempt", run_.score, run_.row_score);
      Same("critical fail of the attempt", run_.critical_fail, run_.row_critical_fail);
      Same("score document of the attempt", run_.score_json, run_.row_score_json);
    }
    ++report_.results;
    auto document = DecodeResult(run_.document);
    if (!document.ok()) {
      Find("a signed result (schemas/result.md)", document.status().message());
      return Status::Ok();
    }
    if (key_ && document->key != *key_) {
      Find("a result signed by this server's ticket.key", "one signed by another key");
      return Status::Ok();
    }
    if (!VerifyResult(*document)) {
      Find("a result as it was signed", "another signature, or a changed document");
      return Status::Ok();
    }
    CheckRow(*document);
    CheckMadeFrom(*document);
    if (run_.run == run_.newest) CheckNewest(*document);
    return CheckReference(*document);
  }

 private:
  void Find(const std::string& expected, const std::string& found) {
    report_.findings.push_back({"result", run_.attempt.Text(),
                                "run " + std::to_string(run_.run) + ": " + expected, found,
                                kScoreAgain});
  }

  template <typename T>
  void Same(const std::string& what, const T& is_signed, const T& is_there) {
    if (is_signed != is_there) Find(what + " " + TextOf(is_signed), TextOf(is_there));
  }

  void CheckRow(const ResultDocument& d) {
    Same("attempt", d.attempt, run_.attempt);
    Same("time of scoring", d.scored_ms, run_.scored_ms);
    Same("points", d.points, run_.score);
    Same("critical fail", d.critical_fail, run_.critical_fail);
    Same("score document", d.score_document, run_.score_json);
    // Of the two newest runs all is kept, of earlier ones only the score; a retention rule removes
    // all of it.
    const bool may_be_gone = run_.expired || run_.run < run_.newest - 1;
    SameFile("final tooth", d.tooth, run_.tooth, may_be_gone);
    SameFile("deviation", d.deviation, run_.deviation, may_be_gone);
    SameFile("curves over time", d.series, run_.series, may_be_gone);
  }

  void SameFile(const std::string& what, const Sha256& is_signed, const Sha256& is_there,
                bool may_be_gone) {
    if (!may_be_gone || !is_there.IsZero()) Same(what, is_signed, is_there);
  }

  Status CheckReference(const ResultDocument& d) {
    Query q(db_, "SELECT head_hash, final_volume FROM attempts WHERE tenant = ?1 AND id = ?2");
    const bool there = q.Bind(d.reference).Next();
    ENAMEL_RETURN_IF_ERROR(q.status());
    // One that was removed, with a person or by a retention rule, is named by no row any more.
    const Uuid named = there ? d.reference : Uuid();
    Same("reference", named, run_.reference.value_or(Uuid()));
    if (run_.run == run_.newest) {
      Same("reference of the attempt", named, run_.row_reference.value_or(Uuid()));
    }
    if (!there) return Status::Ok();
    Same("head of the reference's recording", d.reference_recording, q.Hash(0));
    if (Sha256 tooth = q.Hash(1); !tooth.IsZero())
      Same("reference's tooth", d.reference_tooth, tooth);
    return Status::Ok();
  }

  void CheckMadeFrom(const ResultDocument& d) {
    Same("header", d.header, HashSha256(run_.header));
    Same("head of the recording", d.recording, run_.recording);
    Same("exercise", d.exercise, run_.exercise);
    Same("device profile", d.profile, run_.profile);
    if (auto header = trace::DecodeHeader(run_.header); header.ok()) {
      Same("exercise of the ticket", d.exercise, header->ticket.exercise);
      Same("scene", d.scene, header->scene);
      Same("volume", d.volume, header->volume);
    }
    // A later run may find that no limit is borderline any more.
    if (uint32_t lost = d.flags & ~(run_.flags | kBorderlineScore); lost != 0) {
      for (const char* name : AttemptFlagNames(lost)) Find("flag " + std::string(name), "no flag");
    }
  }

  void CheckNewest(const ResultDocument& d) {
    if (run_.expired) return;
    Same("final tooth of the attempt", d.tooth, run_.row_tooth);
    Same("deviation of the attempt", d.deviation, run_.row_deviation);
    Same("curves over time of the attempt", d.series, run_.row_series);
  }

  Db& db_;
  const Run& run_;
  const std::optional<trace::PublicKey>& key_;
  VerifyReport& report_;
};

// The stored run is the one that the audit trail names last: somebody who removes a run, or its
// document, leaves a row that names it.
Status CheckTrail(Db& db, const Run& run, VerifyReport& report) {
  Query q(db,
          "SELECT after_json FROM audit WHERE tenant = ?1 AND object = ?2 AND action IN (?3, ?4) "
          "ORDER BY id DESC LIMIT 1");
  q.Bind(run.attempt.Text(), kAuditScore, kAuditRestore);
  const std::string told = q.Next() ? q.Text(0) : "{}";
  ENAMEL_RETURN_IF_ERROR(q.status());
  ENAMEL_ASSIGN_OR_RETURN(const auto now,
                          ScoredJson(db, run.attempt, run.score_json, run.document));
  std::map<std::string, std::string> stated = ColumnsOf(told), present = ColumnsOf(now);
  // A retention rule takes the motion with the recording.
  if (run.expired && present["motion"].empty()) stated.erase("motion"), present.erase("motion");
  if (stated != present) {
    report.findings.push_back({"result", run.attempt.Text(),
                               "the newest run that the audit trail names: " + told, now,
                               kScoreAgain});
  }
  return Status::Ok();
}

// Each run has a row of the trail, in their order: what it says of the run, and whether one is
// missing.
Status CheckRuns(Db& db, const Uuid& attempt, const std::map<int64_t, Run>& runs,
                 VerifyReport& report) {
  Query q(db,
          "SELECT after_json FROM audit WHERE tenant = ?1 AND object = ?2 AND action IN (?3, ?4) "
          "ORDER BY id");
  q.Bind(attempt.Text(), kAuditScore, kAuditRestore);
  const auto find = [&](int64_t run, const std::string& expected, const std::string& found) {
    report.findings.push_back({"result", attempt.Text(),
                               "run " + std::to_string(run) + ": " + expected, found, kScoreAgain});
  };
  int64_t run = 0;
  while (q.Next()) {
    const auto at = runs.find(++run);
    if (at == runs.end()) {
      find(run, "a run, which the audit trail names", "none");
      continue;
    }
    auto stated = ColumnsOf(q.Text(0));
    const std::pair<const char*, std::string> present[] = {
        {"score_json", at->second.score_json.Hex()},
        {"result", HashSha256(at->second.document).Hex()},
        {"cause", at->second.cause}};
    for (const auto& [name, value] : present) {
      if (stated[name] == value) continue;
      find(run, std::string(name) + " " + stated[name] + ", as the audit trail says", value);
    }
  }
  ENAMEL_RETURN_IF_ERROR(q.status());
  for (const auto& [number, unused] : runs) {
    if (number > run) find(number, "a row of the audit trail that names it", "none");
  }
  return Status::Ok();
}

// Scored, and no run says how.
Status CheckUnexplained(Db& db, VerifyReport& report) {
  Query q(db,
          "SELECT a.id FROM attempts a WHERE a.tenant = ?1 AND a.score IS NOT NULL AND NOT EXISTS "
          "(SELECT 1 FROM attempt_results r WHERE r.tenant = a.tenant AND r.attempt = a.id)");
  while (q.Next()) {
    report.findings.push_back(
        {"result", q.Id(0).Text(), "a scoring run that gave its score", "no run", kScoreAgain});
  }
  return q.status();
}

}  // namespace

Status CheckResults(Db& db, const std::optional<trace::PublicKey>& key, VerifyReport& report) {
  Query q(db, kRuns);
  std::map<int64_t, Run> runs;  // of the attempt that is looked at
  while (q.Next()) {
    Run run = RunOf(q);
    ENAMEL_RETURN_IF_ERROR(RunCheck(db, run, key, report).Check());
    runs[run.run] = run;
    if (run.run != run.newest) continue;
    ENAMEL_RETURN_IF_ERROR(CheckTrail(db, run, report));
    ENAMEL_RETURN_IF_ERROR(CheckRuns(db, run.attempt, runs, report));
    runs.clear();
  }
  ENAMEL_RETURN_IF_ERROR(q.status());
  return CheckUnexplained(db, report);
}

}  // namespace enamel::server
