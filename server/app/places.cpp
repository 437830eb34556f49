#include "server/app/places.h"

#include <string>
#include <utility>

#include "server/storage/folder/disk.h"
#include "server/storage/keys/key_bucket.h"
#include "server/storage/keys/master_key.h"
#include "server/storage/open_store.h"

namespace enamel::server::app {
namespace {

// Absolute: the folder's files name it from the folder, the command line from where one stands.
std::string Absolute(const std::string& path) {
  return path.empty() ? path : std::filesystem::absolute(path).lexically_normal().string();
}

}  // namespace

Result<std::optional<DatabaseFile>> FileOf(const Places& places) {
  if (!places.blobs.endpoint.empty() && places.database.empty()) {
    return Status(Code::kInvalidInput,
                  "expected --database beside --s3-endpoint, found none: rows in enamel.db are one "
                  "machine's, and what other servers name would be deleted; name a PostgreSQL "
                  "database, or keep the blobs in the folder");
  }
  if (places.database.empty()) return std::optional<DatabaseFile>();
  DatabaseFile file{places.database, places.schema};
  if (places.blobs.endpoint.empty()) return std::optional(file);
  file.blobs = places.blobs;
  file.blobs->ca_file = Absolute(places.blobs.ca_file);
  file.blobs->credentials_file = Absolute(places.blobs.credentials_file);
  if (places.keys.bucket.bucket.empty()) return std::optional(file);
  // In the same store, and with its access key unless another is named.
  file.keys = places.keys;
  PlaceInS3& bucket = file.keys->bucket;
  bucket.endpoint = places.blobs.endpoint;
  bucket.region = places.blobs.region;
  bucket.ca_file = file.blobs->ca_file;
  bucket.credentials_file = bucket.credentials_file.empty() ? file.blobs->credentials_file
                                                            : Absolute(bucket.credentials_file);
  file.keys->master_key_file = Absolute(file.keys->master_key_file);
  return std::optional(file);
}

Status TryStores(const std::filesystem::path& folder, const DatabaseFile& file) {
  if (file.blobs) {
    ENAMEL_ASSIGN_OR_RETURN(const auto place, ReadS3Place(folder, *file.blobs));
    ENAMEL_RETURN_IF_ERROR(TryS3Place(place));
  }
  if (!file.keys) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(const auto keys, ReadKeyBucket(folder, *file.keys));
  ENAMEL_RETURN_IF_ERROR(TryS3Place(keys.place));
  ENAMEL_ASSIGN_OR_RETURN(const auto client, s3::S3Client::Make(keys.place.store));
  return MustForgetWhatIsDeleted(*client);
}

Result<PostgresOptions> FirstOptions(const std::filesystem::path& folder,
                                     const DatabaseFile& file) {
  PostgresOptions out{file.server, file.schema, {folder}};
  if (!file.keys) return out;
  ENAMEL_ASSIGN_OR_RETURN(out.folder.s3_keys, ReadKeyBucket(folder, *file.keys));
  const std::filesystem::path& master = out.folder.s3_keys->master_key;
  ENAMEL_ASSIGN_OR_RETURN(const bool others, HasServers(out));
  ENAMEL_RETURN_IF_ERROR(
      (others ? ReadMasterKey(master) : EnsureMasterKey(master, SystemDisk())).status());
  return out;
}

}  // namespace enamel::server::app
