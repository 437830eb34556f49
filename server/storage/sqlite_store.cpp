#include "server/storage/sqlite_store.h"

#include <algorithm>
#include <cstdlib>
#include <functional>

#include "server/storage/engine/data_folder.h"
#include "server/storage/engine/database_file.h"
#include "server/storage/engine/move_rows.h"
#include "server/storage/engine/pg_database.h"
#include "server/storage/engine/server_id.h"
#include "server/storage/engine/ticket_key.h"
#include "server/storage/folder_keyring.h"
#include "server/storage/key_bucket.h"
#include "server/storage/s3_blobs.h"
#include "server/storage/s3_keyring.h"
#include "server/storage/sql/database_look.h"
#include "server/storage/sql/server_identity.h"
#include "server/storage/sql/sqlite_impl.h"

namespace enamel::server {
namespace {

Disk& DiskOf(const SqliteOptions& options) {
  return options.disk != nullptr ? *options.disk : SystemDisk();
}

}  // namespace

namespace sqlite {
namespace {

std::unique_ptr<Db> Patient(std::unique_ptr<Db> db, std::chrono::milliseconds busy_wait,
                            std::function<bool()> worth_it) {
  db->SetBusyWait(busy_wait, std::move(worth_it));
  return db;
}

// Here and nowhere else, so that no row is written without a signature.
std::unique_ptr<Db> Signing(std::unique_ptr<Db> db, const AuditSigner& signer) {
  db->SetCompanion(&signer);
  return db;
}

}  // namespace

SqliteStore::SqliteStore(const SqliteOptions& options, Database database, FolderLock lock,
                         const trace::SecretKey& ticket_key, const Uuid& server, Buckets buckets)
    : folder_(options.folder),
      lock_(std::move(lock)),
      signer_(ticket_key, server),
      // What runs beside the server without its lock must not be taken for it.
      owner_(options.hold_lock ? server : Uuid::New()),
      many_(!server.IsZero()),
      space_(options.folder, DiskOf(options), options.min_free_bytes, options.free_space_check),
      rewriter_(options.folder, space_, SharedWith(database.open_writer)),
      writer_(Signing(Patient(std::move(database.writer), options.busy_wait,
                              [this] { return rewriter_.OthersErase(); }),
                      signer_),
              options.change_twice),
      readers_(std::move(database.open_reader), options.readers),
      owned_blobs_(MakeBlobs(options, std::move(buckets.blobs))),
      blobs_(*owned_blobs_),
      owned_keyring_(MakeKeyring(options, buckets)),
      keyring_(*owned_keyring_),
      sign_ins_(OwnTransactions(), database.open_writer, ticket_key),
      // Who holds the folder's lock is this server: what an earlier process of it had is over.
      earlier_leases_(options.hold_lock) {
  if (options.hold_lock) sealed_rows_.emplace(writer_);
}

std::unique_ptr<Blobs> SqliteStore::MakeBlobs(const SqliteOptions& options,
                                              std::unique_ptr<s3::S3Client> s3) {
  if (s3 == nullptr) {
    return std::make_unique<FolderBlobs>(
        options.folder / "blobs", DiskOf(options), options.fail_next,
        [this] { return Read([](Db& db) { return NamedBlobs(db); }); });
  }
  return std::make_unique<S3Blobs>(std::move(s3), options.s3_blobs->prefix, OwnTransactions());
}

std::unique_ptr<Keyring> SqliteStore::MakeKeyring(const SqliteOptions& options, Buckets& buckets) {
  if (buckets.keys == nullptr) {
    return std::make_unique<FolderKeyring>(options.folder / "keyring", DiskOf(options));
  }
  return std::make_unique<S3Keyring>(std::move(buckets.keys), options.s3_keys->place.prefix,
                                     *buckets.master, OwnTransactions());
}

std::optional<Rewriter::Shared> SqliteStore::SharedWith(
    const std::function<Result<std::unique_ptr<Db>>()>& open_writer) {
  if (!open_writer) return std::nullopt;
  return Rewriter::Shared{OwnTransactions(), open_writer};
}

Transactions SqliteStore::OwnTransactions() {
  Transactions out;
  out.write = [this](const std::function<Status(Db&)>& work) { return Write(work); };
  out.read = [this](const std::function<Status(Db&)>& work) {
    return Read([&](Db& db) -> Result<bool> {
             Status status = work(db);
             if (!status.ok()) return status;
             return true;
           })
        .status();
  };
  return out;
}

Status SqliteStore::MatchIdentity(ServerPart part, const std::optional<Sha256>& fingerprint) {
  if (!many_) return Status::Ok();
  return Write([&](Db& db) { return MatchIdentityRow(db, part, fingerprint); });
}

Status SqliteStore::LookAtDatabase() {
  if (!many_) return Status::Ok();
  return OwnTransactions().read([this](Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto ahead_ms, FollowClockOf(db));
    clock_ahead_ms_ = ahead_ms.value_or(0);
    ENAMEL_ASSIGN_OR_RETURN(standby_, db.StandbyOf());
    return Status::Ok();
  });
}

Result<Sha256> SqliteStore::PutBlob(ByteView data) {
  ENAMEL_RETURN_IF_ERROR(MayRecord());
  return blobs_.Put(data);
}

Result<Sha256> SqliteStore::PutAttemptBlob(const Uuid& attempt, ByteView data) {
  ENAMEL_RETURN_IF_ERROR(MayRecord());
  ENAMEL_ASSIGN_OR_RETURN(auto key, KeyOf(attempt));
  return blobs_.Put(SealPersonal(key.person, key.key, attempt, data));
}

Result<Bytes> SqliteStore::GetBlob(const Sha256& hash) {
  auto bytes = blobs_.Get(hash);
  if (!bytes.ok()) return bytes;
  return OpenPersonal(keyring_, std::move(bytes).value());
}

Result<Uuid> SqliteStore::PersonOf(const Uuid& attempt) {
  std::string name(AsText(attempt.view()));
  {
    std::lock_guard lock(people_mutex_);
    auto known = person_of_.find(name);
    if (known != person_of_.end()) return known->second;
  }
  ENAMEL_ASSIGN_OR_RETURN(auto row, AttemptById(attempt));
  std::lock_guard lock(people_mutex_);
  // All at once and not the oldest, which is simple: each is found again when it is asked for.
  if (person_of_.size() >= kMaxRemembered) person_of_.clear();
  person_of_[name] = row.person;
  return row.person;
}

Result<SqliteStore::PersonKey> SqliteStore::KeyOf(const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(const Uuid person, PersonOf(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto key, keyring_.FindOrMake(person));
  return PersonKey{person, key};
}

Status SqliteStore::MayRecord() {
  // What is acknowledged is deleted at the stations in time: nothing more is taken into a file that
  // cannot be trusted.
  if (damaged_ || writer_.damaged()) {
    return Status(Code::kUnavailable,
                  "the server's database is damaged: stop the server, see what verify says, and "
                  "restore a backup; recordings wait at the stations");
  }
  return space_.Check();
}

StoreHealth SqliteStore::Health() {
  StoreHealth out;
  out.free_bytes = space_.FreeBytes();
  out.min_free_bytes = space_.min_free_bytes();
  std::error_code error;
  auto size = [&](const char* name) -> uint64_t {
    uintmax_t bytes = std::filesystem::file_size(folder_ / name, error);
    return error ? 0 : bytes;
  };
  out.database_bytes = size("enamel.db");
  out.log_bytes = size("enamel.db-wal");
  Writer::Counters counters = writer_.counters();
  out.commits = counters.commits;
  out.writes = counters.works;
  out.failed_commits = counters.failed_commits;
  out.commit_s = counters.commit_s;
  std::vector<double> took = writer_.newest_commits_s();
  out.timed_commits = took.size();
  if (!took.empty()) {
    // The smallest that at least 99 % are not above.
    const auto place = static_cast<std::ptrdiff_t>((took.size() * 99 + 99) / 100 - 1);
    std::ranges::nth_element(took, took.begin() + place);
    out.commit_p99_s = took[static_cast<size_t>(place)];
  }
  out.chunks = chunks_;
  out.chunk_bytes = chunk_bytes_;
  out.sealed = sealed_;
  out.standby = standby_;
  out.clock_ahead_ms = clock_ahead_ms_;
  if (std::abs(out.clock_ahead_ms) > kMostClockOffMs) {
    out.clock_problem =
        "this machine's clock is " + std::to_string(std::abs(out.clock_ahead_ms) / 1000) + " s " +
        (out.clock_ahead_ms > 0 ? "ahead of" : "behind") +
        " the database server's; see that both machines set theirs from the same time "
        "servers";
  }
  if (Status able = MayRecord(); !able.ok()) out.problem = able.message();
  if (out.problem.empty() && !writer_.last_failure().ok()) {
    out.problem =
        "the last change could not be written to the database; the server's log says why. "
        "Recordings wait at the stations, the next write that succeeds ends this";
  }
  out.takes_recordings = out.problem.empty();
  if (rewriter_.running() || writer_.waits()) {
    out.waiting =
        "a person was erased and the database is being written anew; changes and recordings wait "
        "until that is done";
  }
  if (out.waiting.empty() && standby_ == Standby::kMissing) {
    out.waiting =
        "the database server waits for a synchronous standby, and none is there; every change and "
        "every recording waits until one is";
  }
  if (out.waiting.empty() && !blobs_.Problem().ok()) {
    // What arrives is kept in rows meanwhile.
    out.waiting =
        "the store of blobs cannot be written or read; the server's log says why. Recordings that "
        "end wait at the stations and scores at the server until it can";
  }
  if (out.waiting.empty() && !keyring_.Problem().ok()) {
    out.waiting =
        "the store of keys cannot be written or read; the server's log says why. Recordings of "
        "people whose key is not in memory wait at the stations, and nobody can be erased, until "
        "it can";
  }
  return out;
}

Status SqliteStore::TryWrite() {
  // Only after a failure, to find out whether its cause is gone: otherwise the writes that are made
  // anyway tell.
  if (writer_.last_failure().ok() || writer_.damaged()) return Status::Ok();
  return Write([](Db& db) -> Status {
    Query q(db,
            "INSERT INTO write_probe (tenant, at_ms) VALUES (?1, ?2) ON CONFLICT (tenant) DO "
            "UPDATE SET at_ms = ?2");
    return q.Bind(NowMs()).Run();
  });
}

Status SqliteStore::FinishErasures() {
  if (erasures_due_) ENAMEL_RETURN_IF_ERROR(EraseAgain());
  ENAMEL_ASSIGN_OR_RETURN(const bool marked, rewriter_.IsMarked());
  if (!marked) return Status::Ok();
  auto alone = rewriter_.TakeUpkeep();
  return alone.ok() ? rewriter_.RunIfMarked(writer_) : alone.status();
}

Result<std::unique_ptr<SqliteStore>> OpenWholeStore(const SqliteOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenStore(options));
  return std::unique_ptr<SqliteStore>(static_cast<SqliteStore*>(store.release()));
}

Status Explain(Status status, const std::string& conflict) {
  if (status.code() != Code::kConflict) return status;
  return Status(Code::kConflict, conflict);
}

}  // namespace sqlite

int LatestSchemaVersion() { return sqlite::Migrations().back().version; }

namespace {

using sqlite::SqliteStore;

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
Sha256 KeyRingFingerprint(const SqliteOptions& options, const std::optional<MasterKey>& master) {
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
    const SqliteOptions& options, const std::vector<sql::Migration>& migrations, bool many,
    const std::function<Result<SqliteStore::Database>()>& open) {
  using namespace sqlite;
  ENAMEL_RETURN_IF_ERROR(MakeDataFolder(options.folder, DiskOf(options), options.restoring));
  std::optional<FolderLock> lock;
  auto acquire = [&]() -> Status {
    auto held = FolderLock::Take(options.folder / kServerLock, FolderLock::Mode::kExclusive,
                                 "another enamel-server uses " + options.folder.string() +
                                     "; stop it first or name another folder");
    if (!held.ok()) return held.status();
    lock.emplace(std::move(held).value());
    return Status::Ok();
  };
  if (options.hold_lock) ENAMEL_RETURN_IF_ERROR(acquire());
  auto database = open();
  if (!database.ok()) return database.status();
  Db& db = *database->writer;
  db.SetBusyWait(options.busy_wait);
  ENAMEL_ASSIGN_OR_RETURN(auto version, SchemaVersion(db));
  auto key = ReadTicketKey(options.folder);
  SqliteStore::Buckets buckets;
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
    if (!key.ok()) return key.status();
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
  auto store = std::make_unique<SqliteStore>(options, std::move(database).value(), std::move(kept),
                                             key->secret_key, server, std::move(buckets));
  ENAMEL_RETURN_IF_ERROR(store->LookAtDatabase());
  if (options.hold_lock) ENAMEL_RETURN_IF_ERROR(store->Reconcile());
  return std::unique_ptr<Store>(std::move(store));
}

}  // namespace

Result<std::unique_ptr<Store>> OpenSqliteStore(const SqliteOptions& options) {
  using namespace sqlite;
  const auto path = options.folder / "enamel.db";
  // Before anything is made in a folder that is not ours.
  ENAMEL_RETURN_IF_ERROR(MustBeOurs(path));
  return OpenStoreOn(options, Migrations(), /*many=*/false, [&]() -> Result<SqliteStore::Database> {
    ENAMEL_ASSIGN_OR_RETURN(auto writer,
                            OpenDatabase(path, DbMode::kCreate, options.vfs, options.fail_next));
    return SqliteStore::Database{
        std::move(writer), [path, vfs = options.vfs]() -> Result<std::unique_ptr<Db>> {
          ENAMEL_ASSIGN_OR_RETURN(auto db, OpenDatabase(path, DbMode::kReadOnly, vfs));
          return std::unique_ptr<Db>(std::move(db));
        }};
  });
}

Result<std::unique_ptr<Store>> OpenPostgresStore(const PostgresOptions& options) {
  using namespace sqlite;
  const auto opens = [&](bool read_only) {
    return [server = options.server, schema = options.schema, read_only,
            fail_next = options.folder.fail_next] {
      return OpenPgDatabase(server, schema, read_only,
                            read_only ? std::function<bool()>() : fail_next);
    };
  };
  return OpenStoreOn(options.folder, PgMigrations(), /*many=*/true,
                     [&]() -> Result<SqliteStore::Database> {
                       ENAMEL_ASSIGN_OR_RETURN(auto writer, opens(/*read_only=*/false)());
                       return SqliteStore::Database{std::move(writer), opens(/*read_only=*/true),
                                                    opens(/*read_only=*/false)};
                     });
}

Result<bool> HasServers(const PostgresOptions& options) {
  ENAMEL_ASSIGN_OR_RETURN(const auto db,
                          sqlite::OpenPgDatabase(options.server, options.schema,
                                                 /*read_only=*/true, options.folder.fail_next));
  ENAMEL_ASSIGN_OR_RETURN(const int version, sqlite::SchemaVersion(*db));
  if (version == 0) return false;
  // Something is known by which a new server would be refused.
  const Status none = sqlite::MatchIdentityRow(*db, ServerPart::kKeyRing, {});
  if (none.ok() || none.code() == Code::kNotFound) return !none.ok();
  return none;
}

Result<std::unique_ptr<Store>> OpenStore(const SqliteOptions& options) {
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
