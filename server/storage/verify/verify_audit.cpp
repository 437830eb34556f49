#include "server/storage/verify/verify_audit.h"

#include <algorithm>
#include <boost/json.hpp>
#include <map>
#include <set>
#include <tuple>

#include "common/base/counted.h"
#include "server/storage/audit/audit_row.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/audit/decisions.h"
#include "server/storage/engine/query.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/verify/manifest.h"
#include "server/training/ticket_rules.h"

namespace enamel::server {
namespace {

namespace json = boost::json;

constexpr char kErasedJson[] = R"({"erased":true})";
constexpr char kLookIntoBackup[] =
    "look in a backup for what it was; decide it again on the page, which signs it";
constexpr char kCompareTrail[] =
    "compare the row with the one of a backup; somebody has written to the database";
constexpr uint64_t kToldSignatures = 20;

struct TrailRow {
  AuditSeal seal;
  std::string before, after, state;
  bool has_salt = false;
  AuditSalt salt{};
  trace::Signature signature{};
};

constexpr char kTrailRows[] =
    "SELECT id, at_ms, actor, via, action, object, subject, content_hash, before_json, after_json, "
    "state, salt, signature, chain, number, previous FROM audit WHERE tenant = ?1 ORDER BY id";

TrailRow TrailRowOf(const Query& q) {
  TrailRow out;
  out.seal = {q.Id(0), q.Int(1), q.Id(2), q.Text(3), q.Text(4), q.Text(5), q.Text(6), q.Hash(7)};
  out.before = q.Text(8);
  out.after = q.Text(9);
  out.state = q.Text(10);
  const Bytes salt = q.Blob(11), signature = q.Blob(12);
  // Of another length: counts as missing, which is a finding.
  out.has_salt = salt.size() == out.salt.size();
  if (out.has_salt) std::ranges::copy(salt, out.salt.begin());
  if (signature.size() == out.signature.size()) {
    std::ranges::copy(signature, out.signature.begin());
  }
  out.seal.link = {q.Id(13), static_cast<uint64_t>(q.Int(14)), q.Hash(15)};
  return out;
}

std::string Rows(uint64_t count) { return Counted(count, "row"); }

std::string ValueIn(const std::map<std::string, std::string>& columns, const std::string& name) {
  const auto at = columns.find(name);
  return at == columns.end() ? "" : at->second;
}

class AuditCheck {
 public:
  AuditCheck(Db& db, const std::optional<trace::PublicKey>& key,
             const std::vector<AuditHead>& earlier, VerifyReport& report,
             const UpkeepProgress& progress)
      : db_(db), key_(key), report_(report), progress_(progress), earlier_(earlier) {}

  Status Check() {
    ENAMEL_ASSIGN_OR_RETURN(report_.trail, AuditHeads(db_));
    CheckEarlier();
    ENAMEL_RETURN_IF_ERROR(CheckRows());
    CheckHeads();
    ENAMEL_RETURN_IF_ERROR(CheckStates());
    return CheckUntold();
  }

 private:
  void FindRow(const TrailRow& row, const std::string& expected, const std::string& found) {
    report_.Find("audit", row.seal.id.Text(),
                 "row " + row.seal.action + " of " + TimeText(row.seal.at_ms) + " about " +
                     (row.seal.object.empty() ? "the server" : row.seal.object) + ": " + expected,
                 found, kCompareTrail);
  }

  Result<uint64_t> Count(const char* sql) {
    Query q(db_, sql);
    const uint64_t count = q.Next() ? static_cast<uint64_t>(q.Int(0)) : 0;
    ENAMEL_RETURN_IF_ERROR(q.status());
    return count;
  }

  Status CheckRows() {
    ENAMEL_ASSIGN_OR_RETURN(const uint64_t all,
                            Count("SELECT count(*) FROM audit WHERE tenant = ?1"));
    uint64_t done = 0;
    std::vector<TrailRow> forged;
    Query q(db_, kTrailRows);
    while (q.Next()) {
      const TrailRow row = TrailRowOf(q);
      if (progress_) progress_("rows of the audit trail", ++done, all);
      ++report_.audit_rows;
      ENAMEL_RETURN_IF_ERROR(CheckContent(row));
      const bool is_ours = !key_ || VerifyAuditSeal(row.seal, row.signature, *key_);
      if (!is_ours && forged_++ < kToldSignatures) forged.push_back(row);
      CheckPlace(row, is_ours);
    }
    ENAMEL_RETURN_IF_ERROR(q.status());
    FindForged(forged);
    return Status::Ok();
  }

  // A row follows the one before it in its chain.
  void CheckPlace(const TrailRow& row, bool is_ours) {
    const AuditLink& link = row.seal.link;
    const Sha256 hash = AuditSealHash(row.seal);
    CheckAgainstEarlier(row, hash);
    End& end = ends_[link.chain];
    const uint64_t expected = end.number + 1;
    if (link.number > expected) {
      const uint64_t gone = link.number - expected;
      FindRow(row, "row " + std::to_string(link.number - 1) + " of the trail before it",
              Rows(gone) + " taken away, from row " + std::to_string(expected) + " on");
    } else if (link.number < expected) {
      FindRow(row, "place " + std::to_string(expected) + " in the trail",
              "place " + std::to_string(link.number));
    } else if (end.is_ours && is_ours && link.previous != end.hash) {
      // Not if one of the two was changed: that has its own finding.
      FindRow(row, "the row before it to be the one that it was signed after",
              link.previous.IsZero()
                  ? "nothing before it: the end of the trail was taken away, or cut off, before it "
                    "was written"
                  : "another row");
    }
    end = {std::max(end.number, link.number), row.seal.id, hash, is_ours};
  }

  void CheckEarlier() {
    for (const AuditHead& head : earlier_) {
      if (!key_ || VerifyAuditHead(head, *key_)) continue;
      report_.Find("audit", kManifestName,
                   "ends of the audit trail that this server's ticket.key signed",
                   "another signature, or a changed end", "use another backup");
    }
  }

  // The end at the time of a backup.
  void CheckAgainstEarlier(const TrailRow& row, const Sha256& hash) {
    for (AuditHead& head : earlier_) {
      if (head.chain != row.seal.link.chain || head.number != row.seal.link.number) continue;
      if (head.hash != hash) {
        FindRow(row, "the row " + std::to_string(head.number) + " that the backup has", "another");
      }
      head.number = 0;  // seen
    }
  }

  // The signed end of each chain is its last row.
  void CheckHeads() {
    constexpr char kLookForEnd[] =
        "compare the trail with that of the newest backup; somebody has written to the database";
    for (const AuditHead& head : report_.trail) {
      if (key_ && forged_ < report_.audit_rows && !VerifyAuditHead(head, *key_)) {
        report_.Find("audit", "enamel.db",
                     "the end of the audit trail as this server's ticket.key signed it",
                     "another signature, or a changed end", kLookForEnd);
      }
      const End end = ends_[head.chain];
      if (head.number > end.number) {
        report_.Find(
            "audit", "enamel.db",
            "the audit trail up to row " + std::to_string(head.number) + ", its signed end",
            "row " + std::to_string(end.number) + " is the last one, " +
                Rows(head.number - end.number) + " taken away",
            kLookForEnd);
      } else if (head.number < end.number || head.hash != end.hash || head.last_id != end.id) {
        report_.Find("audit", "enamel.db",
                     "row " + std::to_string(head.number) + " as the signed end of the audit trail",
                     "row " + std::to_string(end.number) + ", or another one in its place",
                     kLookForEnd);
      }
    }
    for (const auto& [chain, end] : ends_) {
      if (std::ranges::find(report_.trail, chain, &AuditHead::chain) != report_.trail.end())
        continue;
      report_.Find("audit", "enamel.db", "a signed end of the audit trail", "none", kLookForEnd);
    }
    for (const AuditHead& head : earlier_) {
      if (head.number == 0) continue;
      report_.Find(
          "audit", "enamel.db",
          "the audit trail up to row " + std::to_string(head.number) + ", which the backup has",
          "row " + std::to_string(ends_[head.chain].number) +
              " is the last one: rows were taken away, or an older state was put back",
          "look in the backup for what is missing; after a restore of an older one this is "
          "expected");
    }
  }

  // A key that was replaced is one finding, not one for each row.
  void FindForged(const std::vector<TrailRow>& some) {
    constexpr char kCompareKey[] = "compare ticket.key and the rows with those of a backup";
    if (forged_ == report_.audit_rows && forged_ > 1) {
      report_.Find("audit", "enamel.db",
                   Rows(forged_) + " of the audit trail signed by this server's ticket.key",
                   "all signed by another key", kCompareKey);
      return;
    }
    for (const TrailRow& row : some)
      FindRow(row, "as this server's ticket.key signed it", "another signature, or a changed row");
    if (forged_ > some.size()) {
      report_.Find("audit", "enamel.db", "rows as this server's ticket.key signed them",
                   Rows(forged_ - some.size()) + " more with another signature", kCompareKey);
    }
  }

  Status CheckContent(const TrailRow& row) {
    if (row.has_salt) {
      if (AuditContentHash(row.salt, row.before, row.after, row.state) != row.seal.content)
        FindRow(row, "before, after and state as they were signed", "other content");
      return Status::Ok();
    }
    const bool state_is_erased = row.state.empty() || row.state == kErasedJson;
    if (row.before != kErasedJson || row.after != kErasedJson || !state_is_erased) {
      FindRow(row, "a salt, as the row is not erased", "none");
      return Status::Ok();
    }
    ENAMEL_ASSIGN_OR_RETURN(const bool gone, PersonIsErased(row.seal.object));
    if (!gone) FindRow(row, "its content, as its person was not erased", kErasedJson);
    return Status::Ok();
  }

  // Of a person's id, or of an attempt that was a person's: whether an erasure in the trail tells
  // why it is not here.
  Result<bool> PersonIsErased(const std::string& object) {
    const auto known = erased_.find(object);
    if (known != erased_.end()) return known->second;
    std::string person = object;
    {
      Query q(db_,
              "SELECT after_json FROM audit WHERE tenant = ?1 AND object = ?2 AND action = "
              "'attempt.ticket'");
      if (q.Bind(object).Next()) person = ColumnsOf(q.Text(0))["person"];
      ENAMEL_RETURN_IF_ERROR(q.status());
    }
    bool gone = false;
    if (const auto id = Uuid::Parse(person); id.ok()) {
      Query q(db_,
              "SELECT 1 FROM audit WHERE tenant = ?1 AND object = ?2 AND action = 'person.erase' "
              "AND NOT EXISTS (SELECT 1 FROM people WHERE tenant = ?1 AND id = ?3)");
      gone = q.Bind(TombstoneOf(*id).Hex(), *id).Next();
      ENAMEL_RETURN_IF_ERROR(q.status());
    }
    erased_[object] = gone;
    return gone;
  }

  // The last row about each subject states the present state.
  Status CheckStates() {
    Query q(db_,
            "SELECT DISTINCT subject FROM audit WHERE tenant = ?1 AND subject <> '' ORDER BY "
            "subject");
    ENAMEL_ASSIGN_OR_RETURN(const auto subjects, q.All<std::string>());
    uint64_t done = 0;
    for (const std::string& subject : subjects) {
      if (progress_) progress_("decisions", ++done, subjects.size());
      ENAMEL_RETURN_IF_ERROR(CheckState(subject));
      told_.insert(subject);
    }
    report_.decisions = subjects.size();
    return Status::Ok();
  }

  Status CheckState(const std::string& subject) {
    static const std::string kSql = std::string("SELECT action, at_ms, object, state FROM audit ") +
                                    "WHERE " + kAboutSubject + " ORDER BY id DESC LIMIT 1";
    Query q(db_, kSql);
    if (!q.Bind(subject).Next()) return q.status();
    const std::string object = q.Text(2), state = q.Text(3);
    const std::string row = q.Text(0) + " of " + TimeText(q.Int(1));
    auto now = StateOf(db_, subject);
    if (!now.ok() && now.status().code() == Code::kStorage) return now.status();
    // No subject of ours, or erased: the row itself is found above where that is wrong.
    if (!now.ok() || state == kErasedJson || ColumnsOf(state) == ColumnsOf(*now)) {
      return Status::Ok();
    }
    const size_t space = subject.find(' ');
    const std::string kind = subject.substr(0, space), key = subject.substr(space + 1);
    if (now->empty()) return CheckGone(kind, key, object, row, ColumnsOf(state));
    if (state.empty()) {
      report_.Find("decision", key, "no " + kind + ", as the audit trail says (" + row + ")", "one",
                   kLookIntoBackup);
      return Status::Ok();
    }
    FindColumns(kind, key, row, ColumnsOf(state), ColumnsOf(*now));
    return Status::Ok();
  }

  // A person is erased, an attempt and a saved text go with their person, its remarks and blind marks with the
  // attempt, a blind marking with its assignment. A session ends without a row, and its end gives
  // nobody anything.
  Status CheckGone(const std::string& kind, const std::string& key, const std::string& object,
                   const std::string& row, const std::map<std::string, std::string>& stated) {
    if (kind == "session") return Status::Ok();
    if (kind == "person" || kind == "attempt" || kind == "annotation" || kind == "saved_text") {
      ENAMEL_ASSIGN_OR_RETURN(const bool erased, PersonIsErased(object));
      if (erased) return Status::Ok();
    }
    if (kind == "member") {
      ENAMEL_ASSIGN_OR_RETURN(const bool erased, PersonIsErased(key.substr(key.find(' ') + 1)));
      if (erased) return Status::Ok();
    }
    for (const auto& [of, whole, id] :
         {std::tuple("annotation", "attempt", object),
          std::tuple("work", "attempt", ValueIn(stated, "attempt")),
          std::tuple("work", "marking", ValueIn(stated, "marking")),
          std::tuple("marking", "assignment", ValueIn(stated, "assignment"))}) {
      if (kind != of) continue;
      ENAMEL_ASSIGN_OR_RETURN(const auto there, StateOf(db_, SubjectOf(whole, id)));
      if (there.empty()) return Status::Ok();
    }
    report_.Find("decision", key, "the " + kind + " that the audit trail records (" + row + ")",
                 "none", kLookIntoBackup);
    return Status::Ok();
  }

  void FindColumns(const std::string& kind, const std::string& key, const std::string& row,
                   std::map<std::string, std::string> stated,
                   std::map<std::string, std::string> present) {
    std::set<std::string> names;
    for (const auto& columns : {stated, present}) {
      for (const auto& [name, value] : columns) names.insert(name);
    }
    auto text = [](const std::string& value) { return value.empty() ? "nothing" : value; };
    for (const std::string& name : names) {
      if (stated[name] == present[name]) continue;
      report_.Find(
          "decision", key,
          kind + ": " + name + " " + text(stated[name]) + ", as the audit trail says (" + row + ")",
          name + " " + text(present[name]), kLookIntoBackup);
    }
  }

  // A subject without a row in the trail was put there by hand.
  Status CheckUntold() {
    ENAMEL_ASSIGN_OR_RETURN(const auto present, PresentSubjects(db_));
    for (const auto& [subject, object] : present) {
      if (told_.contains(subject)) continue;
      const size_t space = subject.find(' ');
      report_.Find("decision", subject.substr(space + 1),
                   "a row of the audit trail that records this " + subject.substr(0, space), "none",
                   kLookIntoBackup);
    }
    return Status::Ok();
  }

  Db& db_;
  const std::optional<trace::PublicKey>& key_;
  VerifyReport& report_;
  const UpkeepProgress& progress_;
  // Where the rows that were looked at end, in one chain.
  struct End {
    uint64_t number = 0;
    Uuid id;
    Sha256 hash;
    bool is_ours = true;
  };
  std::map<Uuid, End> ends_;
  std::vector<AuditHead> earlier_;
  uint64_t forged_ = 0;  // rows with another signature
  std::map<std::string, bool> erased_;
  std::set<std::string> told_;
};

}  // namespace

Status CheckAudit(Db& db, const std::optional<trace::PublicKey>& key,
                  const std::vector<AuditHead>& earlier, VerifyReport& report,
                  const UpkeepProgress& progress) {
  return AuditCheck(db, key, earlier, report, progress).Check();
}

}  // namespace enamel::server
