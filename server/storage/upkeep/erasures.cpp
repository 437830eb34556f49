#include "server/storage/upkeep/erasures.h"

#include <spdlog/spdlog.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/base/counted.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/engine/query.h"
#include "server/storage/keys/key_rows.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/people/people_rows.h"
#include "server/storage/teaching/exercise_owners.h"
#include "server/storage/upkeep/deletion.h"

// Erasing a person: the key first, then the rows, then the blobs.
namespace enamel::server {
namespace {

Result<std::vector<Uuid>> Ids(Query& q) { return q.All<Uuid>(); }

Result<std::vector<Uuid>> AttemptsOf(Db& db, const Uuid& person) {
  Query q(db, "SELECT id FROM attempts WHERE tenant = ?1 AND person = ?2");
  return Ids(q.Bind(person));
}

// Asked before anything is erased: a reference is what others' scores were compared with.
Result<std::vector<Uuid>> ReferencesBy(Db& db, const Uuid& person) {
  Query q(
      db,
      "SELECT r.attempt FROM reference_cuts r JOIN attempts a ON a.tenant = r.tenant AND a.id = "
      "r.attempt WHERE r.tenant = ?1 AND a.person = ?2 ORDER BY r.attempt");
  return Ids(q.Bind(person));
}

Result<std::vector<Uuid>> PeopleIn(Db& db) {
  Query q(db, "SELECT id FROM people WHERE tenant = ?1");
  return Ids(q);
}

// Runs `work` with overwriting of deleted content, which costs too much to have it always on.
Status WithOverwriting(Db& db, const std::function<Status()>& work) {
  ENAMEL_RETURN_IF_ERROR(db.OverwriteDeleted(true));
  Status status = work();
  Status off = db.OverwriteDeleted(false);
  return status.ok() ? off : status;
}

// Redacts the audit trail's words about an erased person and that person's attempts, including
// attempts that a retention rule removed before. Who did it and when stays, and stays signed. The
// database admits no other change of audit rows (schemas/sql/0001_initial.sql).
Status RedactAudit(Db& db, const Uuid& person) {
  static constexpr char kErased[] = R"('{"erased":true}')";
  const std::string sql =
      std::string("UPDATE audit SET before_json = ") + kErased + ", after_json = " + kErased +
      ", state = CASE state WHEN '' THEN '' ELSE " + kErased +
      " END, salt = NULL WHERE tenant = ?1 AND ((object = ?2 AND (action LIKE 'person.%' OR action "
      "LIKE "
      "'session.%' OR action = 'request.refused')) OR "
      "(action <> 'attempt.ticket' AND object IN (SELECT object FROM audit WHERE tenant = ?1 "
      "AND action = 'attempt.ticket' AND " +
      db.JsonMember("after_json", "person") + " = ?2)))";
  Query q(db, sql);
  return q.Bind(person.Text()).Run();
}

}  // namespace

Status DeletePerson(Db& db, const Uuid& person, const Tombstone& tombstone, const Actor& by,
                    ErasureReport& report, std::set<Sha256>& blobs) {
  ENAMEL_ASSIGN_OR_RETURN(auto attempts, AttemptsOf(db, person));
  ENAMEL_ASSIGN_OR_RETURN(auto references, ReferencesBy(db, person));
  report.attempts += attempts.size();
  report.references += references.size();
  ENAMEL_RETURN_IF_ERROR(DeleteAttempts(db, attempts, blobs));
  ENAMEL_RETURN_IF_ERROR(GiveNamesToSchool(db, person, by));
  for (const char* sql : {"DELETE FROM sessions WHERE tenant = ?1 AND person = ?2",
                          "DELETE FROM cohort_members WHERE tenant = ?1 AND person = ?2",
                          "DELETE FROM saved_texts WHERE tenant = ?1 AND owner = ?2",
                          "DELETE FROM people WHERE tenant = ?1 AND id = ?2"}) {
    ENAMEL_RETURN_IF_ERROR(Query(db, sql).Bind(person).Run());
  }
  // After the rows: the database admits it only for a person without a row (0001_initial.sql).
  ENAMEL_RETURN_IF_ERROR(RedactAudit(db, person));
  ENAMEL_RETURN_IF_ERROR(AddErasure(db, tombstone));
  return WriteAudit(db, by, "person.erase", tombstone.person.Hex(),
                    JsonOf({{"attempts", std::to_string(attempts.size())}}), "{}");
}

Result<ErasureReport> Erasures::ErasePerson(const Uuid& person, bool with_references,
                                            const Actor& by) {
  ENAMEL_ASSIGN_OR_RETURN(auto found, rows_.Read([&](Db& db) { return FindPerson(db, person); }));
  auto references = rows_.Read([&](Db& db) { return ReferencesBy(db, person); });
  ENAMEL_RETURN_IF_ERROR(references.status());
  if (!references->empty() && !with_references) {
    return Status(Code::kConflict,
                  Counted(references->size(), "attempt of this person is a reference cut",
                          "attempts of this person are reference cuts") +
                      ", the first is " + references->front().Text() +
                      "; make another attempt the reference first, or erase with the references");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto alone, rewriter_.TakeUpkeep());
  ENAMEL_RETURN_IF_ERROR(rows_
                             .Read([&](Db& db) -> Result<bool> {
                               ENAMEL_RETURN_IF_ERROR(MustNotBeTheOnlyAdmin(db, found));
                               return true;
                             })
                             .status());
  Tombstone tombstone{TombstoneOf(person), NowMs()};
  // The order is what makes it safe: the mark, so that a crash leaves the rewrite to be done; then
  // the key, after which nothing kept under it can be read by anybody; then the rows. After a crash
  // the start finds the key gone and deletes the rows (Reconcile).
  ENAMEL_RETURN_IF_ERROR(rewriter_.Mark());
  ENAMEL_RETURN_IF_ERROR(keyring_.Destroy(person, tombstone.erased_ms));
  ErasureReport report;
  std::vector<Blobs::Freed> freed;
  const Status deleted = rows_.Write([&](Db& db) -> Status {
    report = {};
    std::set<Sha256> blobs;
    ENAMEL_RETURN_IF_ERROR(WithOverwriting(
        db, [&] { return DeletePerson(db, person, tombstone, by, report, blobs); }));
    ENAMEL_ASSIGN_OR_RETURN(freed, blobs_.Free(db, blobs));
    return Status::Ok();
  });
  ENAMEL_RETURN_IF_ERROR(deleted);
  ENAMEL_ASSIGN_OR_RETURN(auto removed, blobs_.Remove(freed));
  report.blobs = removed;
  report.finished = rewriter_.RunIfMarked().ok();
  // The person's own texts are gone by now.
  auto mentions = rows_.Read([&](Db& db) { return MentionsOf(db, found); });
  ENAMEL_RETURN_IF_ERROR(mentions.status());
  report.mentions = std::move(*mentions);
  return report;
}

Result<std::vector<Tombstone>> Erasures::AllErased() {
  ENAMEL_ASSIGN_OR_RETURN(auto all, rows_.Read([](Db& db) { return ErasuresIn(db); }));
  const auto theirs = keyring_.Gone();
  if (theirs.ok()) all.insert(all.end(), theirs->begin(), theirs->end());
  const Status buried = !theirs.ok()  ? theirs.status()
                        : all.empty() ? Status::Ok()
                                      : keyring_.Bury(all);
  // A bucket may be away while a server starts: those that the database knows of are erased all the
  // same.
  due_ = buried.code() == Code::kUnavailable;
  if (!buried.ok() && !due_) return buried;
  if (due_) {
    spdlog::warn(
        "erasures were not compared with the key ring, which is tried again within an hour: {}",
        buried.message());
  }
  return all;
}

Status Erasures::Reconcile() {
  if (sealed_ != nullptr) {
    ENAMEL_RETURN_IF_ERROR(sealed_->Find());
  }
  return EraseAgain();
}

Status Erasures::EraseAgain() {
  ENAMEL_ASSIGN_OR_RETURN(const auto gone, AllErased());
  if (gone.empty()) return Status::Ok();
  // By the hash of the id: the list of erasures does not say who was erased.
  std::map<Sha256, Tombstone> tombstones;
  for (const Tombstone& tombstone : gone) tombstones[tombstone.person] = tombstone;
  auto people = rows_.Read([](Db& db) { return PeopleIn(db); });
  ENAMEL_RETURN_IF_ERROR(people.status());
  std::vector<Blobs::Freed> all_freed;
  for (const Uuid& person : *people) {
    auto tombstone = tombstones.find(TombstoneOf(person));
    if (tombstone == tombstones.end()) continue;
    ENAMEL_RETURN_IF_ERROR(rewriter_.Mark());
    std::vector<Blobs::Freed> freed;
    const Status deleted = rows_.Write([&](Db& db) -> Status {
      std::set<Sha256> blobs;
      ErasureReport report;
      ENAMEL_RETURN_IF_ERROR(WithOverwriting(db, [&] {
        return DeletePerson(db, person, tombstone->second, Actor{{}, "list of erasures"}, report,
                            blobs);
      }));
      ENAMEL_ASSIGN_OR_RETURN(freed, blobs_.Free(db, blobs));
      return Status::Ok();
    });
    ENAMEL_RETURN_IF_ERROR(deleted);
    all_freed.insert(all_freed.end(), freed.begin(), freed.end());
    // An erasure beside this start may have removed the first mark meanwhile.
    ENAMEL_RETURN_IF_ERROR(rewriter_.Mark());
  }
  return blobs_.Remove(all_freed).status();
}

Status Erasures::FinishErasures() {
  if (due_) ENAMEL_RETURN_IF_ERROR(EraseAgain());
  ENAMEL_ASSIGN_OR_RETURN(const bool marked, rewriter_.IsMarked());
  if (!marked) return Status::Ok();
  auto alone = rewriter_.TakeUpkeep();
  return alone.ok() ? rewriter_.RunIfMarked() : alone.status();
}

}  // namespace enamel::server
