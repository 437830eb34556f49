#include "server/app/data_folder.h"

#include "common/base/file.h"
#include "common/net/certificate.h"
#include "server/app/command_line.h"
#include "server/app/say.h"
#include "server/storage/engine/data_folder.h"
#include "server/storage/engine/database_file.h"
#include "server/storage/engine/folder_lock.h"
#include "server/storage/engine/ticket_key.h"
#include "server/storage/key_bucket.h"
#include "server/storage/master_key.h"
#include "server/storage/sqlite_store.h"

namespace enamel::server::app {
namespace {

constexpr size_t kMaxIdentityBytes = 1 << 20;

struct InitCommand {
  std::filesystem::path data;
  std::string database;  // of PostgreSQL; empty: SQLite in the folder
  std::string schema = "enamel";
  PlaceInS3 blobs;                 // without an endpoint: in the folder
  KeysInS3 keys;                   // without a bucket: in the folder
  std::filesystem::path identity;  // of another server; empty: its own
};

// Absolute: the folder's files name it from the folder, the command line from where one stands.
std::string Absolute(const std::string& path) {
  return path.empty() ? path : std::filesystem::absolute(path).lexically_normal().string();
}

// Whether the stores can be used as the file says.
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

// What a folder is opened with that has no database.json yet. The master key is made for a school's first
// server alone: another's mistyped path is not to become a key.
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

// Where --database, --s3-… and --key-… say that things are.
DatabaseFile FileOf(const InitCommand& command) {
  DatabaseFile file{command.database, command.schema};
  if (command.blobs.endpoint.empty()) return file;
  file.blobs = command.blobs;
  file.blobs->ca_file = Absolute(command.blobs.ca_file);
  file.blobs->credentials_file = Absolute(command.blobs.credentials_file);
  if (command.keys.bucket.bucket.empty()) return file;
  // In the same store, and with its access key unless another is named.
  file.keys = command.keys;
  PlaceInS3& bucket = file.keys->bucket;
  bucket.endpoint = command.blobs.endpoint;
  bucket.region = command.blobs.region;
  bucket.ca_file = file.blobs->ca_file;
  bucket.credentials_file = bucket.credentials_file.empty() ? file.blobs->credentials_file
                                                            : Absolute(bucket.credentials_file);
  file.keys->master_key_file = Absolute(file.keys->master_key_file);
  return file;
}

Status Init(const InitCommand& command) {
  if (!command.blobs.endpoint.empty() && command.database.empty()) {
    return Status(Code::kInvalidInput,
                  "expected --database beside --s3-endpoint, found none: rows in enamel.db are one "
                  "machine's, and what other servers name would be deleted; name a PostgreSQL "
                  "database, or keep the blobs in the folder");
  }
  const DatabaseFile file = FileOf(command);
  if (!command.database.empty()) {
    ENAMEL_RETURN_IF_ERROR(MayKeepRowsIn(command.data, file));
    ENAMEL_RETURN_IF_ERROR(TryStores(command.data, file));
  }
  if (!command.identity.empty()) {
    ENAMEL_RETURN_IF_ERROR(TakeIdentity(command.data, command.identity));
  }
  if (!command.database.empty()) {
    ENAMEL_ASSIGN_OR_RETURN(const auto options, FirstOptions(command.data, file));
    // Before the file says so: a folder must not be bound to a server that cannot be reached, nor
    // one that holds other things be taken for ours.
    if (auto opened = OpenPostgresStore(options); !opened.ok()) return opened.status();
    ENAMEL_RETURN_IF_ERROR(WriteDatabaseFile(command.data, file, SystemDisk()));
  }
  return InitData(command.data);
}

// Makes the certificate unless it is there; its fingerprint.
Result<Sha256> EnsureCertificate(const std::filesystem::path& certificate,
                                 const std::filesystem::path& private_key,
                                 const std::string& name) {
  std::error_code error;
  if (!std::filesystem::exists(certificate, error)) {
    Status made = net::CreateCertificateFiles(certificate, private_key, name);
    // Another command of ours was faster.
    bool there = made.code() == Code::kConflict && std::filesystem::exists(certificate, error);
    if (!made.ok() && !there) return made;
  }
  ENAMEL_ASSIGN_OR_RETURN(auto pem, ReadFile(certificate, 1 << 20));
  return net::CertificateFingerprint(pem);
}

}  // namespace

Status TakeIdentity(const std::filesystem::path& folder, const std::filesystem::path& from) {
  std::vector<std::pair<std::filesystem::path, Bytes>> missing;
  for (const char* name : sqlite::kIdentityFiles) {
    auto theirs = ReadFile(from / name, kMaxIdentityBytes);
    if (!theirs.ok()) {
      return Status(theirs.status().code(),
                    "expected station.crt, station.key and ticket.key of another server in " +
                        from.string() + ", found no readable " + name +
                        "; copy the three from its data folder",
                    "identity");
    }
    auto mine = ReadFile(folder / name, kMaxIdentityBytes);
    if (mine.status().code() == Code::kNotFound) {
      missing.emplace_back(folder / name, std::move(*theirs));
      continue;
    }
    if (!mine.ok()) return mine.status();
    if (*mine == *theirs) continue;
    return Status(Code::kConflict,
                  "expected the " + std::string(name) + " of " + from.string() + " in " +
                      folder.string() +
                      ", found another: this folder is another server's; name the folder of one "
                      "that has the same, or a new data folder",
                  "identity");
  }
  // First what it is: no key is written where others may look in.
  if (!missing.empty()) {
    ENAMEL_RETURN_IF_ERROR(sqlite::MakeDataFolder(folder, SystemDisk(), /*restoring=*/false));
  }
  for (const auto& [path, content] : missing) {
    ENAMEL_RETURN_IF_ERROR(SystemDisk().Replace(path, content));
  }
  return Status::Ok();
}

Result<ServerIdentity> EnsureIdentity(const std::filesystem::path& folder) {
  ServerIdentity identity;
  identity.certificate = folder / "station.crt";
  identity.private_key = folder / "station.key";
  ENAMEL_ASSIGN_OR_RETURN(
      auto fingerprint,
      EnsureCertificate(identity.certificate, identity.private_key, "enamel-server"));
  identity.fingerprint = fingerprint;
  ENAMEL_ASSIGN_OR_RETURN(auto keys, EnsureTicketKey(folder, SystemDisk()));
  identity.ticket_key = keys;
  return identity;
}

Result<ServerIdentity> EnsureMatchingIdentity(const std::filesystem::path& folder, Store& store) {
  std::error_code error;
  if (!std::filesystem::exists(folder / "station.crt", error)) {
    // Before one is made that would be refused then.
    ENAMEL_RETURN_IF_ERROR(store.MatchIdentity(ServerPart::kStationCertificate, {}));
  }
  ENAMEL_ASSIGN_OR_RETURN(auto identity, EnsureIdentity(folder));
  ENAMEL_RETURN_IF_ERROR(
      store.MatchIdentity(ServerPart::kStationCertificate, identity.fingerprint));
  return identity;
}

Result<PageCertificate> EnsurePageCertificate(const std::filesystem::path& folder,
                                              const std::vector<std::string>& host_names) {
  PageCertificate page;
  page.certificate = folder / "page.crt";
  page.private_key = folder / "page.key";
  ENAMEL_ASSIGN_OR_RETURN(auto fingerprint,
                          EnsureCertificate(page.certificate, page.private_key,
                                            host_names.empty() ? "localhost" : host_names.front()));
  page.fingerprint = fingerprint;
  return page;
}

Status InitData(const std::filesystem::path& folder) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenStore({folder}));
  ENAMEL_ASSIGN_OR_RETURN(auto identity, EnsureMatchingIdentity(folder, *store));
  Say("data folder {}, fingerprint {}\n", folder.string(), identity.fingerprint.Hex());
  return Status::Ok();
}

void DeclareInit(CommandGroup root) {
  auto [cmd, options] = Declare<InitCommand>(
      root, "init", "Make a data folder, for commands that come before the first serve", Init);
  AddData(cmd, options.data);
  auto* database = cmd->add_option("--database", options.database,
                                   "Keep the rows in this PostgreSQL 15 database instead of "
                                   "enamel.db: postgresql://USER@HOST/NAME");
  cmd->add_option("--schema", options.schema, "Name of the tables' place in that database")
      ->needs(database)
      ->capture_default_str();
  auto* endpoint = cmd->add_option("--s3-endpoint", options.blobs.endpoint,
                                   "Keep the blobs in this S3 store instead of the folder: "
                                   "https://HOST[:PORT]");
  auto* bucket =
      cmd->add_option("--s3-bucket", options.blobs.bucket, "Its bucket")->needs(endpoint);
  endpoint->needs(bucket);
  cmd->add_option("--s3-region", options.blobs.region,
                  "Region that requests are signed for; without: us-east-1")
      ->needs(endpoint);
  cmd->add_option("--s3-prefix", options.blobs.prefix, "Of every key in the bucket: school/")
      ->needs(endpoint);
  cmd->add_option("--s3-ca-file", options.blobs.ca_file,
                  "PEM file of who signed the store's certificate")
      ->needs(endpoint);
  cmd->add_option("--s3-credentials", options.blobs.credentials_file,
                  "File of its access key (schemas/database.md); without: AWS_ACCESS_KEY_ID and "
                  "AWS_SECRET_ACCESS_KEY, for every command")
      ->needs(endpoint);
  auto* keys = cmd->add_option("--key-bucket", options.keys.bucket.bucket,
                               "Keep the keys of people's recordings in this bucket of the store, "
                               "for several servers: one that keeps no versions and locks nothing")
                   ->needs(endpoint);
  auto* master = cmd->add_option("--master-key", options.keys.master_key_file,
                                 "File of the key that they are wrapped with, the same on all "
                                 "servers; made by the first")
                     ->needs(keys);
  keys->needs(master);
  cmd->add_option("--key-prefix", options.keys.bucket.prefix, "Of every key in that bucket")
      ->needs(keys);
  cmd->add_option("--key-credentials", options.keys.bucket.credentials_file,
                  "File of that bucket's access key; without: that of the blobs")
      ->needs(keys);
  AddIdentity(cmd, options.identity);
  cmd->footer(
      "Several servers of one school: the first is made with --database, --s3-endpoint, "
      "--s3-bucket,\n--key-bucket and --master-key. Copy station.crt, station.key and ticket.key "
      "of "
      "its data folder\nand the master key to the next machine, and name them there:\n\n"
      "  enamel-server init --data /srv/enamel --database postgresql://enamel@db/school \\\n"
      "    --s3-endpoint https://s3.example.org --s3-bucket school --key-bucket school-keys \\\n"
      "    --master-key /etc/enamel/master.key --identity /etc/enamel/identity");
}

Result<std::unique_ptr<Store>> OpenOrMake(const std::filesystem::path& folder) {
  return OpenStore({folder});
}

Result<std::unique_ptr<Store>> OpenForCommand(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::exists(folder / "enamel.db", error) &&
      !std::filesystem::exists(folder / kDatabaseFile, error)) {
    return Status(Code::kNotFound,
                  "expected the data folder of an enamel-server, found " +
                      (error ? error.message() : "none") + " at " + folder.string() +
                      "; look at --data and ENAMEL_DATA, or make one with: enamel-server init "
                      "--data " +
                      folder.string());
  }
  SqliteOptions options;
  options.folder = folder;
  return OpenStore(options);
}

}  // namespace enamel::server::app
