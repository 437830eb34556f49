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

void AddPlaces(CLI::App* cmd, Places& places) {
  auto* database = cmd->add_option("--database", places.database,
                                   "Keep the rows in this PostgreSQL 15 database instead of "
                                   "enamel.db: postgresql://USER@HOST/NAME");
  cmd->add_option("--schema", places.schema, "Name of the tables' place in that database")
      ->needs(database)
      ->capture_default_str();
  auto* endpoint = cmd->add_option("--s3-endpoint", places.blobs.endpoint,
                                   "Keep the blobs in this S3 store instead of the folder: "
                                   "https://HOST[:PORT]");
  auto* bucket = cmd->add_option("--s3-bucket", places.blobs.bucket, "Its bucket")->needs(endpoint);
  endpoint->needs(bucket);
  cmd->add_option("--s3-region", places.blobs.region,
                  "Region that requests are signed for; without: us-east-1")
      ->needs(endpoint);
  cmd->add_option("--s3-prefix", places.blobs.prefix, "Of every key in the bucket: school/")
      ->needs(endpoint);
  cmd->add_option("--s3-ca-file", places.blobs.ca_file,
                  "PEM file of who signed the store's certificate")
      ->needs(endpoint);
  cmd->add_option("--s3-credentials", places.blobs.credentials_file,
                  "File of its access key (schemas/database.md); without: AWS_ACCESS_KEY_ID and "
                  "AWS_SECRET_ACCESS_KEY, for every command")
      ->needs(endpoint);
  auto* keys = cmd->add_option("--key-bucket", places.keys.bucket.bucket,
                               "Keep the keys of people's recordings in this bucket of the store, "
                               "for several servers: one that keeps no versions and locks nothing")
                   ->needs(endpoint);
  auto* master = cmd->add_option("--master-key", places.keys.master_key_file,
                                 "File of the key that they are wrapped with, the same on all "
                                 "servers; made by the first")
                     ->needs(keys);
  keys->needs(master);
  cmd->add_option("--key-prefix", places.keys.bucket.prefix, "Of every key in that bucket")
      ->needs(keys);
  cmd->add_option("--key-credentials", places.keys.bucket.credentials_file,
                  "File of that bucket's access key; without: that of the blobs")
      ->needs(keys);
}

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
