#include "server/storage/school/delete_store.h"

#include <string>
#include <vector>

#include "server/s3/s3_client.h"
#include "server/storage/attempts/live_rows.h"
#include "server/storage/engine/database.h"
#include "server/storage/engine/pg_database.h"
#include "server/storage/engine/query.h"
#include "server/storage/folder/disk.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/folder/server_id.h"

namespace enamel::server {

namespace fs = std::filesystem;

namespace {

Status DeleteUnder(const S3Place& place) {
  // An empty prefix would be the whole bucket, including others' objects.
  if (place.prefix.empty()) {
    return {Code::kConflict, "expected a prefix of the school's own in bucket " +
                                 place.store.bucket + ", found none; nothing of it is deleted"};
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto client, s3::S3Client::Make(place.store));
  std::vector<std::string> keys;
  ENAMEL_RETURN_IF_ERROR(client->ListEach(
      place.prefix, [&](s3::ListedObject& object) { keys.push_back(std::move(object.key)); }));
  for (const std::string& key : keys) ENAMEL_RETURN_IF_ERROR(client->Delete(key));
  return Status::Ok();
}

Status RemoveFolder(const fs::path& folder) {
  std::error_code error;
  // Follows a link to another disk: its content is the school's.
  const fs::path real = fs::weakly_canonical(folder, error);
  if (!error) fs::remove_all(real, error);
  if (!error) fs::remove(folder, error);
  if (!error) return Status::Ok();
  return {Code::kStorage, "cannot delete " + folder.string() + ": " + error.message()};
}

// Servers other than this folder's, whose lock we hold.
Status NoServerMayHave(sql::Db& db, const fs::path& folder) {
  const auto version = SchemaVersion(db);
  if (!version.ok() || *version == 0) return version.status();  // deleted already
  ENAMEL_ASSIGN_OR_RETURN(const Uuid own, EnsureServerId(folder, SystemDisk()));
  Query q(db,
          "SELECT count(*) FROM running_servers WHERE tenant = ?1 AND server <> ?2 AND "
          "heard_ms >= ?3");
  const bool told = q.Bind(own, NowMs() - LiveRows::kServerSilentMs).Next();
  if (!told) return q.status();
  if (q.Int(0) == 0) return Status::Ok();
  return {Code::kUnavailable, "a server has not let go of " + folder.string() + " yet",
          kServerHasIt};
}

Status DeleteRows(const DatabaseFile& database) {
  ENAMEL_ASSIGN_OR_RETURN(const auto db,
                          OpenPgDatabase(database.server, {}, /*read_only=*/false, {}));
  std::string quoted;
  for (const char c : database.schema) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return db->Exec(("DROP SCHEMA IF EXISTS \"" + quoted + "\" CASCADE").c_str());
}

}  // namespace

Status DeleteStore(const fs::path& folder, const std::optional<DatabaseFile>& database) {
  // Until the end: nobody may open a half-deleted school.
  const auto lock = FolderLock::Take(folder / kServerLock, FolderLock::Mode::kExclusive,
                                     "a server has not let go of " + folder.string() + " yet");
  if (lock.status().code() == Code::kUnavailable) {
    return {Code::kUnavailable, lock.status().message(), kServerHasIt};
  }
  ENAMEL_RETURN_IF_ERROR(lock.status());
  if (!database) {
    ENAMEL_RETURN_IF_ERROR(RemoveFolder(folder / "keyring"));
    return RemoveFolder(folder);
  }
  {
    ENAMEL_ASSIGN_OR_RETURN(const auto db, OpenPgDatabase(database->server, database->schema,
                                                          /*read_only=*/true, {}));
    ENAMEL_RETURN_IF_ERROR(NoServerMayHave(*db, folder));
  }
  if (database->keys) {
    ENAMEL_ASSIGN_OR_RETURN(const auto keys, ReadKeyBucket(folder, *database->keys));
    ENAMEL_RETURN_IF_ERROR(DeleteUnder(keys.place));
  }
  ENAMEL_RETURN_IF_ERROR(DeleteRows(*database));
  if (database->blobs) {
    ENAMEL_ASSIGN_OR_RETURN(const auto place, ReadS3Place(folder, *database->blobs));
    ENAMEL_RETURN_IF_ERROR(DeleteUnder(place));
  }
  return RemoveFolder(folder);
}

}  // namespace enamel::server
