#include "server/storage/open_store.h"

#include <atomic>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "server/storage/engine/database.h"
#include "server/storage/engine/move_marks.h"
#include "server/storage/engine/pg_database.h"
#include "server/storage/folder/data_folder.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/server_id.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/keys/key_bucket.h"
#include "server/storage/store_engine.h"

namespace enamel::server {
namespace {

// Keys that were made in the folder would not be found any more, and others made beside them.
Status MustHaveNoKeysIn(const std::filesystem::path& keyring) {
  std::error_code error;
  for (std::filesystem::directory_iterator it(keyring, error), end; !error && it != end;
       it.increment(error)) {
    if (it->path().extension() != ".key") continue;
    return Status(Code::kConflict,
                  "expected all keys in the bucket that database.json names, found " +
                      it->path().string() +
                      ": this school's keys are in the folder; make a new data "
                      "folder for a school whose keys are in a bucket");
  }
  return Status::Ok();
}

// Servers with another key ring would make a second key for a person. Hosts may have several names.
Sha256 KeyRingFingerprint(const StoreOptions& options, const std::optional<MasterKey>& master) {
  std::string text = "folder";
  if (options.s3_keys) {
    const S3Place& place = options.s3_keys->place;
    text = place.store.bucket + "\n" + place.prefix + "\n" + master->Fingerprint().Hex();
  }
  return HashSha256(AsBytes(text));
}

// `open` gives a database that waits for nobody yet; `migrations` are its engine's. `many`: other
// servers have their rows in it too.
Result<std::unique_ptr<Store>> OpenStoreOn(
    const StoreOptions& options, const std::vector<sql::Migration>& migrations, bool many,
    const std::function<Result<Transactions::Connections>()>& open) {
  ENAMEL_RETURN_IF_ERROR(MakeDataFolder(options.folder, DiskOf(options), options.restoring));
  std::optional<FolderLock> lock;
  auto acquire = [&]() -> Status {
    auto held = FolderLock::Take(options.folder / kServerLock, FolderLock::Mode::kExclusive,
                                 "another enamel-server uses " + options.folder.string() +
                                     "; stop it first or name another folder");
    ENAMEL_RETURN_IF_ERROR(held.status());
    lock.emplace(std::move(held).value());
    return Status::Ok();
  };
  if (options.hold_lock) ENAMEL_RETURN_IF_ERROR(acquire());
  auto database = open();
  ENAMEL_RETURN_IF_ERROR(database.status());
  Db& db = *database->writer;
  db.SetBusyWait(options.busy_wait);
  ENAMEL_ASSIGN_OR_RETURN(auto version, SchemaVersion(db));
  auto key = ReadTicketKey(options.folder);
  StoreEngine::Buckets buckets;
  if (options.s3_keys) {
    ENAMEL_ASSIGN_OR_RETURN(buckets.master, ReadMasterKey(options.s3_keys->master_key));
    ENAMEL_ASSIGN_OR_RETURN(buckets.keys, s3::S3Client::Make(options.s3_keys->place.store));
    ENAMEL_RETURN_IF_ERROR(MustHaveNoKeysIn(options.folder / "keyring"));
    // Commands beside the server rely on its look. It may be away while a server starts.
    const Status forgets =
        options.hold_lock ? MustForgetWhatIsDeleted(*buckets.keys) : Status::Ok();
    if (!forgets.ok() && forgets.code() != Code::kUnavailable) return forgets;
  }
  const auto match = [&]() -> Status {
    std::optional<Sha256> ticket_key;
    if (key.ok()) ticket_key = HashSha256(key->public_key);
    sql::Transaction transaction(db, sql::Isolation::kRowLocks);
    ENAMEL_RETURN_IF_ERROR(transaction.begun());
    ENAMEL_RETURN_IF_ERROR(MatchIdentityRow(db, ServerPart::kTicketKey, ticket_key));
    ENAMEL_RETURN_IF_ERROR(
        MatchIdentityRow(db, ServerPart::kKeyRing, KeyRingFingerprint(options, buckets.master)));
    return transaction.Commit();
  };
  // A server that is refused has changed nothing before.
  const bool matches_first = many && version > 0;
  if (matches_first) ENAMEL_RETURN_IF_ERROR(match());
  const bool had_key = key.ok();
  if (version < LatestSchemaVersion() || !key.ok()) {
    // A tool beside a running server must not change the schema under it, nor its key.
    if (!lock) ENAMEL_RETURN_IF_ERROR(acquire());
    key = EnsureTicketKey(options.folder, DiskOf(options));
    ENAMEL_RETURN_IF_ERROR(key.status());
    ENAMEL_RETURN_IF_ERROR(db.Migrate(migrations));
  }
  Uuid server;
  if (many) {
    if (!matches_first || !had_key) ENAMEL_RETURN_IF_ERROR(match());
    if (!options.restoring) ENAMEL_RETURN_IF_ERROR(MustNotBeMoved(db));
    ENAMEL_ASSIGN_OR_RETURN(server, EnsureServerId(options.folder, DiskOf(options)));
  }
  const AuditSigner signer(key->secret_key, server);
  db.SetCompanion(&signer);
  if (!options.hold_lock) lock.reset();
  if (options.s3_blobs) {
    ENAMEL_ASSIGN_OR_RETURN(buckets.blobs, s3::S3Client::Make(options.s3_blobs->store));
  }
  FolderLock kept = lock ? std::move(*lock) : FolderLock();
  auto store = std::make_unique<Store>(
      std::make_unique<StoreEngine>(options, std::move(database).value(), std::move(kept),
                                    key->secret_key, server, std::move(buckets)));
  ENAMEL_RETURN_IF_ERROR(store->look.Look());
  if (options.hold_lock) ENAMEL_RETURN_IF_ERROR(store->erasures.Reconcile());
  return store;
}

}  // namespace

Result<std::unique_ptr<Store>> OpenSqliteStore(const StoreOptions& options) {
  const auto path = options.folder / "enamel.db";
  // Before anything is made in a folder that is not ours.
  ENAMEL_RETURN_IF_ERROR(MustBeOurs(path, options.vfs));
  return OpenStoreOn(
      options, SqliteMigrations(), /*many=*/false, [&]() -> Result<Transactions::Connections> {
        ENAMEL_ASSIGN_OR_RETURN(
            auto writer, OpenDatabase(path, DbMode::kCreate, options.vfs, options.fail_next));
        return Transactions::Connections{
            std::move(writer), [path, vfs = options.vfs]() -> Result<std::unique_ptr<Db>> {
              ENAMEL_ASSIGN_OR_RETURN(auto db, OpenDatabase(path, DbMode::kReadOnly, vfs));
              // A page of a list by name or by score reads some 400 pages of the file in any
              // order: with SQLite's 2 MB most come from the system again for the next page.
              ENAMEL_RETURN_IF_ERROR(db->Exec("PRAGMA cache_size = -4096"));
              return std::unique_ptr<Db>(std::move(db));
            }};
      });
}

Result<std::unique_ptr<Store>> OpenPostgresStore(const PostgresOptions& options) {
  const auto newest = std::make_shared<std::atomic<int64_t>>(0);
  const auto opens = [&](bool read_only) {
    return [server = options.server, schema = options.schema, read_only, newest,
            fail_next = options.folder.fail_next] {
      return OpenPgDatabase(server, schema, read_only,
                            read_only ? std::function<bool()>() : fail_next, newest);
    };
  };
  return OpenStoreOn(
      options.folder, PgMigrations(), /*many=*/true, [&]() -> Result<Transactions::Connections> {
        ENAMEL_ASSIGN_OR_RETURN(auto writer, opens(/*read_only=*/false)());
        return Transactions::Connections{std::move(writer), opens(/*read_only=*/true),
                                         opens(/*read_only=*/false), newest};
      });
}

Result<bool> HasServers(const PostgresOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(const auto db,
                          OpenPgDatabase(options.server, options.schema,
                                         /*read_only=*/true, options.folder.fail_next));
  ENAMEL_ASSIGN_OR_RETURN(const int version, SchemaVersion(*db));
  if (version == 0) return false;
  // Something is known by which a new server would be refused.
  const Status none = MatchIdentityRow(*db, ServerPart::kKeyRing, {});
  if (none.ok() || none.code() == Code::kNotFound) return !none.ok();
  return none;
}

Result<std::unique_ptr<Store>> OpenStore(const StoreOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(const auto database, ReadDatabaseFile(options.folder));
  if (!database) return OpenSqliteStore(options);
  PostgresOptions postgres{database->server, database->schema, options};
  if (database->blobs) {
    ENAMEL_ASSIGN_OR_RETURN(postgres.folder.s3_blobs,
                            ReadS3Place(options.folder, *database->blobs));
  }
  if (database->keys) {
    ENAMEL_ASSIGN_OR_RETURN(postgres.folder.s3_keys,
                            ReadKeyBucket(options.folder, *database->keys));
  }
  return OpenPostgresStore(postgres);
}

}  // namespace enamel::server
