#include "server/storage/verify/verify.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <set>
#include <thread>

#include "server/storage/audit/audit_row.h"
#include "server/storage/blobs/named_blobs.h"
#include "server/storage/engine/database.h"
#include "server/storage/engine/query.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/disk.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/keys/key_rows.h"
#include "server/storage/keys/keyring.h"
#include "server/storage/verify/manifest.h"
#include "server/storage/verify/verify_attempts.h"
#include "server/storage/verify/verify_audit.h"
#include "server/storage/verify/verify_results.h"
#include "server/storage/verify/verify_stage.h"

namespace enamel::server {
namespace {

namespace fs = std::filesystem;

class Verifier {
 public:
  explicit Verifier(const VerifyOptions& options)
      : options_(options),
        stored_{.blobs = FolderBlobs(options.folder / "blobs", SystemDisk()),
                .keyring = FolderKeyring(
                    options.keyring.empty() ? options.folder / "keyring" : options.keyring,
                    SystemDisk())} {}

  Result<VerifyReport> Run() {
    fs::path path = options_.folder / "enamel.db";
    std::error_code error;
    report_.is_backup = fs::exists(options_.folder / kManifestName, error);
    // A database without a manifest is what a backup leaves that failed: it may be empty, and agree
    // with itself.
    if (options_.must_be_backup && !report_.is_backup) {
      return ReadManifest(options_.folder).status();
    }
    ENAMEL_RETURN_IF_ERROR(MustHaveRowsInFolder(options_.folder, "verify"));
    if (!fs::exists(path, error)) {
      return Status(Code::kNotFound, "there is no enamel.db in " + options_.folder.string() +
                                         "; name a data folder or a backup");
    }
    if (!options_.since.empty()) {
      ENAMEL_ASSIGN_OR_RETURN(auto manifest, ReadManifest(options_.since));
      earlier_ = std::move(manifest.trail);
    }
    if (report_.is_backup) CheckManifest();
    ENAMEL_ASSIGN_OR_RETURN(auto db, OpenDatabase(path, DbMode::kReadOnly));
    // One reading transaction over all: a server may write meanwhile.
    Status begun = db->Exec("BEGIN");
    auto schema = begun.ok() ? SchemaVersion(*db) : Result<int>(begun);
    // Not damage: another program's file, or a newer one, is for another program to judge.
    if (!schema.ok() && schema.status().code() == Code::kVersion) return schema.status();
    if (!schema.ok()) {
      report_.Find("database", path.string(), "a database that can be read",
                   schema.status().message(), kFromBackup);
      return report_;
    }
    report_.schema = *schema;
    if (Status status = CheckAll(*db); !status.ok()) {
      report_.Find("database", path.string(), "a database that can be read to its end",
                   status.message(), kFromBackup);
    }
    return report_;
  }

 private:
  void Tell(const char* what, uint64_t done, uint64_t all) const {
    if (options_.progress) options_.progress(what, done, all);
  }

  Status CheckAll(Db& db) {
    // From the bottom up: what the pages say is believed below only when they are whole.
    ENAMEL_RETURN_IF_ERROR(CheckDatabase(db));
    // Verifying changes nothing, so an older database is not migrated; the statements below are for
    // the newest.
    if (report_.schema < LatestSchemaVersion()) {
      report_.notes.push_back(
          "the database has schema " + std::to_string(report_.schema) +
          " and was not checked further; start the server once, which brings it to schema " +
          std::to_string(LatestSchemaVersion()));
      return Status::Ok();
    }
    ENAMEL_ASSIGN_OR_RETURN(auto named, NamedBlobs(db));
    std::error_code error;
    stored_.has_keys = fs::exists(stored_.keyring.folder(), error);
    ENAMEL_RETURN_IF_ERROR(CheckBlobs(named));
    ENAMEL_RETURN_IF_ERROR(CheckPeople(db));
    LoadTicketKey();
    ENAMEL_RETURN_IF_ERROR(CheckAttempts(db, stored_, ticket_key_, report_, options_.progress));
    ENAMEL_RETURN_IF_ERROR(CheckResults(db, ticket_key_, report_));
    ENAMEL_RETURN_IF_ERROR(CheckTimelines(db));
    ENAMEL_RETURN_IF_ERROR(CheckStages(db, report_));
    return CheckAudit(db, ticket_key_, earlier_, report_, options_.progress);
  }

  // A playback is in no signed result: that it was made of its own attempt is in its envelope.
  Status CheckTimelines(Db& db) {
    Query q(db, "SELECT attempt, content FROM timelines WHERE tenant = ?1 AND content IS NOT NULL");
    while (q.Next()) {
      if (!stored_.has_keys || stored_.bad.contains(q.Hash(1)))
        continue;  // noted, or found already
      const auto sealed = stored_.blobs.Get(q.Hash(1));
      if (!sealed.ok() || !PersonOfSealed(*sealed)) continue;
      const auto own = IsOfAttempt(stored_.keyring, *sealed, q.Id(0));
      if (own.ok() && !*own) {
        report_.Find("timeline", q.Id(0).Text(), "the playback that was made of this attempt",
                     "one of another attempt",
                     "have the attempt scored again, which makes the playback again");
      }
    }
    return q.status();
  }

  void CheckManifest() {
    auto manifest = ReadManifest(options_.folder);
    if (!manifest.ok()) {
      report_.Find("file", kManifestName, "a manifest (schemas/backup.md)",
                   manifest.status().message(), "make a new backup");
      return;
    }
    // The manifest has to agree with the backup's own database as well.
    earlier_.insert(earlier_.end(), manifest->trail.begin(), manifest->trail.end());
    if (!manifest->keyring_inside && options_.keyring.empty()) {
      report_.notes.push_back(
          "the keys of this backup are kept apart: what is kept under them was not opened; name "
          "them with --keyring");
    }
    std::set<std::string> listed;
    uint64_t done = 0;
    for (const Manifest::File& file : manifest->files) {
      listed.insert(file.path);
      Tell("files of the manifest", ++done, manifest->files.size());
      if (file.path.starts_with("blobs/")) {
        in_manifest_.insert(*Sha256::FromHex(fs::path(file.path).filename().string()));
        continue;  // its name is its hash, and blobs are all read below
      }
      auto content = SystemDisk().Hash(options_.folder / file.path);
      if (!content.ok()) {
        report_.Find("file", file.path, "a file of " + std::to_string(file.bytes) + " bytes",
                     content.status().message(), "use another backup");
      } else if (content->hash != file.hash) {
        report_.Find("file", file.path, "content " + file.hash.Hex(), content->hash.Hex(),
                     "use another backup");
      }
    }
    FindUnlisted(listed);
  }

  // What the manifest does not list is not restored: somebody may count on it.
  void FindUnlisted(const std::set<std::string>& listed) {
    std::error_code error;
    for (fs::recursive_directory_iterator it(options_.folder, error), end; !error && it != end;
         it.increment(error)) {
      std::string path = it->path().lexically_relative(options_.folder).generic_string();
      if (it->is_directory(error) || path == kManifestName || listed.contains(path)) continue;
      report_.Find("file", path, "only files that the manifest lists", "a file more",
                   "take it away, or make a new backup");
    }
  }

  Status CheckDatabase(Db& db) {
    Tell("database", 0, 1);
    sql::Query integrity(db, "PRAGMA integrity_check(100)");
    while (integrity.Next()) {
      if (integrity.Text(0) != "ok")
        report_.Find("database", "enamel.db", "a whole database", integrity.Text(0), kFromBackup);
    }
    ENAMEL_RETURN_IF_ERROR(integrity.status());
    sql::Query keys(db, "PRAGMA foreign_key_check");
    while (keys.Next()) {
      report_.Find("database", keys.Text(0), "rows that name existing rows of " + keys.Text(2),
                   "row " + keys.Text(1) + " names one that does not exist", kFromBackup);
    }
    Tell("database", 1, 1);
    return keys.status();
  }

  Status CheckBlobs(const std::set<Sha256>& named) {
    ENAMEL_ASSIGN_OR_RETURN(auto listing, stored_.blobs.List());
    for (const fs::path& other : listing.others) {
      report_.notes.push_back(other.string() +
                              " is no blob: what an interrupted write left, or put "
                              "there by hand");
    }
    uint64_t done = 0;
    for (const Sha256& hash : listing.blobs) {
      CheckBlob(hash, named.contains(hash));
      Tell("blobs", ++done, listing.blobs.size());
    }
    for (const Sha256& hash : named) {
      if (std::ranges::binary_search(listing.blobs, hash)) continue;
      report_.Find("blob", hash.Hex(), "a blob that the database names", "no such file",
                   kFromBackup);
    }
    for (const Sha256& hash : in_manifest_) {
      if (named.contains(hash) || std::ranges::binary_search(listing.blobs, hash)) continue;
      report_.Find("blob", hash.Hex(), "a blob that the manifest lists", "no such file",
                   "use another backup");
    }
    return Status::Ok();
  }

  void CheckBlob(const Sha256& hash, bool is_named) {
    auto content = stored_.blobs.Get(hash);
    if (!content.ok()) {
      stored_.bad.insert(hash);
      if (is_named) {
        report_.Find("blob", hash.Hex(), "content with this hash", content.status().message(),
                     kFromBackup);
      } else {
        report_.notes.push_back("blob " + hash.Hex() +
                                " is damaged; nothing names it, so nothing is lost");
      }
      return;
    }
    ++report_.blobs;
    report_.blob_bytes += content->size();
    if (!is_named) {
      ++report_.unnamed_blobs;
      report_.unnamed_bytes += content->size();
      return;
    }
    if (!stored_.has_keys || !PersonOfSealed(*content)) return;
    auto opened = OpenPersonal(stored_.keyring, std::move(content).value());
    if (opened.ok()) return;
    stored_.bad.insert(hash);
    report_.Find("key", hash.Hex(), "a blob that its person's key opens", opened.status().message(),
                 "restore the key ring");
  }

  Status CheckPeople(Db& db) {
    std::set<Uuid> people;
    std::set<Sha256> gone;
    Query q(db, "SELECT id FROM people WHERE tenant = ?1");
    while (q.Next()) people.insert(q.Id(0));
    ENAMEL_RETURN_IF_ERROR(q.status());
    ENAMEL_ASSIGN_OR_RETURN(auto erased, ErasuresIn(db));
    auto buried = stored_.keyring.Gone();
    auto keys = stored_.keyring.People();
    for (const Status& status : {buried.status(), keys.status()}) {
      if (!status.ok())
        report_.Find("key", stored_.keyring.folder().string(), "a key ring", status.message(),
                     kFromBackup);
    }
    // Half of a list would call people erased who are not, or the other way round.
    if (!buried.ok() || !keys.ok()) return Status::Ok();
    for (const auto& list : {erased, *buried}) {
      for (const Tombstone& tombstone : list) gone.insert(tombstone.person);
    }
    report_.people = people.size();
    report_.keys = keys->size();
    report_.erased = gone.size();
    for (const Uuid& person : people) {
      if (gone.contains(TombstoneOf(person))) FindErased(person, "rows of an erased person");
    }
    for (const Uuid& person : *keys) {
      if (gone.contains(TombstoneOf(person))) FindErased(person, "the key of an erased person");
    }
    return Status::Ok();
  }

  void FindErased(const Uuid& person, const std::string& found) {
    report_.Find("erasure", person.Text(), "nothing of a person who was erased", found,
                 "start the server once: it finishes erasures");
  }

  void LoadTicketKey() {
    auto key = ReadTicketKey(options_.folder);
    if (key.ok()) {
      ticket_key_ = key->public_key;
    } else {
      report_.notes.push_back(
          "ticket.key is not here: tickets, results and the audit trail were not compared with it");
    }
  }

  const VerifyOptions& options_;
  StoredBlobs stored_;
  VerifyReport report_;
  std::set<Sha256> in_manifest_;
  std::vector<AuditHead> earlier_;
  std::optional<trace::PublicKey> ticket_key_;
};

// Removing takes several steps, between which things disagree that will agree again.
Result<FolderLock> WaitUntilNothingIsRemoved(const fs::path& folder) {
  constexpr auto kPatience = std::chrono::seconds(30);
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  for (;;) {
    auto lock = TakeUpkeepLock(folder, FolderLock::Mode::kShared);
    bool later = !lock.ok() && lock.status().code() == Code::kUnavailable;
    if (!later || std::chrono::steady_clock::now() > deadline) return lock;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

}  // namespace

Result<VerifyReport> Verify(const VerifyOptions& options) {
  // At first without waiting for anybody, as nearly always nothing is found.
  auto report = Verifier(options).Run();
  if (!report.ok() || report->is_backup || report->findings.empty()) return report;
  auto quiet = WaitUntilNothingIsRemoved(options.folder);
  if (quiet.ok()) return Verifier(options).Run();
  if (quiet.status().code() == Code::kUnavailable) {
    report->notes.push_back(
        "recordings are being removed from this folder just now; what was found may be part of "
        "that: run this again when it is done");
  }
  return report;
}

}  // namespace enamel::server
