#include "server/storage/folder/database_file.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cstdlib>
#include <tuple>

#include "common/base/file.h"
#include "common/base/uuid.h"
#include "server/storage/folder/private_file.h"

namespace enamel::server {
namespace {

namespace json = boost::json;

constexpr std::string_view kDatabaseFormat = "enamel-database";
constexpr int64_t kDatabaseVersion = 1;
constexpr size_t kMaxDatabaseBytes = 64 << 10;
constexpr size_t kMaxPrefix = 200;

Status Bad(const std::filesystem::path& path, const std::string& found) {
  return Status(
      Code::kInvalidInput,
      path.string() + ": expected the form in schemas/database.md, found " + found + "; mend it");
}

// `format`: of the member of that name; empty: the file has none.
Result<json::object> ParseObject(const std::filesystem::path& path, const Bytes& bytes,
                                 std::string_view format) {
  boost::system::error_code bad;
  json::value document = json::parse(AsText(bytes), bad);
  if (bad || !document.is_object()) return Bad(path, "no JSON object");
  const json::value* its_format = document.get_object().if_contains("format");
  const json::value* version = document.get_object().if_contains("version");
  if (!format.empty() && (its_format == nullptr || !its_format->is_string() ||
                          std::string_view(its_format->get_string()) != format)) {
    return Bad(path, "no format \"" + std::string(format) + "\"");
  }
  if (version == nullptr || !version->is_int64()) return Bad(path, "no version");
  if (version->get_int64() != kDatabaseVersion) {
    return Status(Code::kVersion, path.string() + " has version " +
                                      std::to_string(version->get_int64()) +
                                      ", this enamel-server reads " +
                                      std::to_string(kDatabaseVersion) + "; run the newer one");
  }
  return std::move(document.get_object());
}

enum class Need { kMust, kMay };

Status ReadText(const std::filesystem::path& path, const json::object& all, const char* name,
                Need need, std::string& into) {
  const json::value* value = all.if_contains(name);
  if (value == nullptr && need == Need::kMay) return Status::Ok();
  if (value == nullptr || !value->is_string() || value->get_string().empty())
    return Bad(path, std::string("no text as ") + name);
  into = value->get_string();
  return Status::Ok();
}

Result<PlaceInS3> ReadPlace(const std::filesystem::path& path, const json::value& value,
                            const char* name) {
  if (!value.is_object()) return Bad(path, std::string("no object as ") + name);
  const json::object& all = value.get_object();
  PlaceInS3 out;
  for (auto [member, need, into] :
       {std::tuple{"endpoint", Need::kMust, &out.endpoint},
        std::tuple{"region", Need::kMay, &out.region},
        std::tuple{"bucket", Need::kMust, &out.bucket},
        std::tuple{"prefix", Need::kMay, &out.prefix},
        std::tuple{"ca_file", Need::kMay, &out.ca_file},
        std::tuple{"credentials_file", Need::kMay, &out.credentials_file}}) {
    ENAMEL_RETURN_IF_ERROR(ReadText(path, all, member, need, *into));
  }
  return out;
}

json::object ObjectOf(const PlaceInS3& place) {
  json::object out = {{"endpoint", place.endpoint}, {"bucket", place.bucket}};
  for (auto [name, text] : {std::pair{"region", &place.region}, std::pair{"prefix", &place.prefix},
                            std::pair{"ca_file", &place.ca_file},
                            std::pair{"credentials_file", &place.credentials_file}}) {
    if (!text->empty()) out[name] = *text;
  }
  return out;
}

Status MustBeAPrefix(const std::string& prefix) {
  const auto may = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-' || c == '/';
  };
  if (prefix.size() <= kMaxPrefix && !prefix.starts_with('/') && std::ranges::all_of(prefix, may))
    return Status::Ok();
  return Status(Code::kInvalidInput,
                "expected a prefix of at most 200 letters, digits, \".\", \"_\", \"-\" and "
                "\"/\", found another as prefix; choose one like school/",
                "prefix");
}

Result<s3::Credentials> ReadCredentials(const std::filesystem::path& path) {
  ENAMEL_ASSIGN_OR_RETURN(
      const Bytes bytes,
      ReadPrivateFile(path, kMaxDatabaseBytes, "the S3 store's credentials", "write it"));
  ENAMEL_ASSIGN_OR_RETURN(const json::object all, ParseObject(path, bytes, {}));
  s3::Credentials out;
  ENAMEL_RETURN_IF_ERROR(ReadText(path, all, "access_key", Need::kMust, out.access_key));
  ENAMEL_RETURN_IF_ERROR(ReadText(path, all, "secret_key", Need::kMust, out.secret_key));
  ENAMEL_RETURN_IF_ERROR(ReadText(path, all, "session_token", Need::kMay, out.session_token));
  return out;
}

Result<s3::Credentials> CredentialsOfEnvironment() {
  const char* const key = std::getenv("AWS_ACCESS_KEY_ID");
  const char* const secret = std::getenv("AWS_SECRET_ACCESS_KEY");
  const char* const token = std::getenv("AWS_SESSION_TOKEN");
  if (key != nullptr && secret != nullptr)
    return s3::Credentials{key, secret, token == nullptr ? "" : token};
  return Status(Code::kInvalidInput,
                "expected the S3 store's credentials in AWS_ACCESS_KEY_ID and "
                "AWS_SECRET_ACCESS_KEY, found them not set; set them, or name a credentials_file "
                "(schemas/database.md)",
                "credentials");
}

// "password=…" among libpq's words, or "user:password@" in a URL.
bool HoldsPassword(const std::string& server) {
  if (server.find("password") != std::string::npos) return true;
  const size_t begin = server.find("://");
  const size_t at = server.find('@');
  return begin != std::string::npos && at != std::string::npos &&
         server.substr(begin + 3, at - begin - 3).find(':') != std::string::npos;
}

// Anybody who can read the one must have nothing of the other.
Status MustHaveKeysApart(const DatabaseFile& file) {
  if (!file.blobs || !file.keys || file.blobs->endpoint != file.keys->bucket.endpoint ||
      file.blobs->bucket != file.keys->bucket.bucket) {
    return Status::Ok();
  }
  return Status(Code::kInvalidInput,
                "expected a bucket for keys and another for blobs, found " + file.blobs->bucket +
                    " for both; name one that has nothing else in it",
                "key-bucket");
}

}  // namespace

Result<std::optional<DatabaseFile>> ReadDatabaseFile(const std::filesystem::path& folder) {
  const auto path = folder / kDatabaseFile;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::optional<DatabaseFile>();
  ENAMEL_ASSIGN_OR_RETURN(const Bytes bytes, ReadFile(path, kMaxDatabaseBytes));
  ENAMEL_ASSIGN_OR_RETURN(const json::object all, ParseObject(path, bytes, kDatabaseFormat));
  DatabaseFile out;
  const json::value* blobs = all.if_contains("blobs");
  const json::value* keys = all.if_contains("keys");
  if ((blobs != nullptr || keys != nullptr) && all.if_contains("server") == nullptr) {
    return Status(Code::kInvalidInput,
                  path.string() +
                      ": expected rows in PostgreSQL beside what is in an S3 store, found no "
                      "server: rows in enamel.db are one machine's, and what others name would be "
                      "deleted; name the PostgreSQL server, or keep all of it in the folder");
  }
  ENAMEL_RETURN_IF_ERROR(ReadText(path, all, "server", Need::kMust, out.server));
  ENAMEL_RETURN_IF_ERROR(ReadText(path, all, "schema", Need::kMust, out.schema));
  if (HoldsPassword(out.server)) {
    ENAMEL_RETURN_IF_ERROR(
        ReadPrivateFile(path, kMaxDatabaseBytes, "the database's password", "").status());
  }
  if (blobs != nullptr) {
    ENAMEL_ASSIGN_OR_RETURN(out.blobs, ReadPlace(path, *blobs, "blobs"));
  }
  if (keys != nullptr) {
    out.keys.emplace();
    ENAMEL_ASSIGN_OR_RETURN(out.keys->bucket, ReadPlace(path, *keys, "keys"));
    ENAMEL_RETURN_IF_ERROR(ReadText(path, keys->get_object(), "master_key_file", Need::kMust,
                                    out.keys->master_key_file));
  }
  ENAMEL_RETURN_IF_ERROR(MustHaveKeysApart(out));
  return std::optional<DatabaseFile>(std::move(out));
}

Result<S3Place> ReadS3Place(const std::filesystem::path& folder, const PlaceInS3& place) {
  ENAMEL_RETURN_IF_ERROR(MustBeAPrefix(place.prefix));
  S3Place out;
  out.prefix = place.prefix;
  out.store.endpoint = place.endpoint;
  out.store.bucket = place.bucket;
  if (!place.region.empty()) out.store.region = place.region;
  if (!place.ca_file.empty()) out.store.ca_file = folder / place.ca_file;
  ENAMEL_ASSIGN_OR_RETURN(auto credentials, place.credentials_file.empty()
                                                ? CredentialsOfEnvironment()
                                                : ReadCredentials(folder / place.credentials_file));
  out.store.credentials = std::move(credentials);
  return out;
}

Result<StoreOptions::KeyBucket> ReadKeyBucket(const std::filesystem::path& folder,
                                              const KeysInS3& keys) {
  ENAMEL_ASSIGN_OR_RETURN(auto place, ReadS3Place(folder, keys.bucket));
  return StoreOptions::KeyBucket{std::move(place), folder / keys.master_key_file};
}

Status TryS3Place(const S3Place& place) {
  ENAMEL_ASSIGN_OR_RETURN(const auto client, s3::S3Client::Make(place.store));
  const std::string key = place.prefix + "tried-" + Uuid::New().Text();
  const Bytes body = {'e', 'n', 'a', 'm', 'e', 'l'};
  ENAMEL_RETURN_IF_ERROR(client->Put(key, body));
  ENAMEL_RETURN_IF_ERROR(client->Get(key, HashSha256(body), body.size()).status());
  ENAMEL_RETURN_IF_ERROR(client->List(place.prefix).status());
  return client->Delete(key);
}

Status MustHaveRowsInFolder(const std::filesystem::path& folder, const std::string& command) {
  ENAMEL_ASSIGN_OR_RETURN(const auto database, ReadDatabaseFile(folder));
  if (!database) return Status::Ok();
  return Status(Code::kConflict, "expected rows in " + (folder / "enamel.db").string() +
                                     ", found that they are in PostgreSQL (database.json), which " +
                                     command +
                                     " does not read; make a backup, which it does: enamel-server "
                                     "backup TARGET --data " +
                                     folder.string());
}

Status MayKeepRowsIn(const std::filesystem::path& folder, const DatabaseFile& file) {
  ENAMEL_RETURN_IF_ERROR(MustHaveKeysApart(file));
  std::error_code error;
  if (std::filesystem::exists(folder / "enamel.db", error)) {
    return Status(Code::kConflict, "expected a folder without rows, found " +
                                       (folder / "enamel.db").string() + "; name another folder");
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto there, ReadDatabaseFile(folder));
  if (there && (there->server != file.server || there->schema != file.schema)) {
    return Status(Code::kConflict, "the rows of " + folder.string() + " are in schema " +
                                       there->schema +
                                       " of another database already (database.json); name "
                                       "another folder");
  }
  if (there && (there->blobs != file.blobs || there->keys != file.keys)) {
    return Status(Code::kConflict,
                  std::string(there->blobs != file.blobs ? "the blobs" : "the keys") + " of " +
                      folder.string() +
                      " are elsewhere already (database.json); name another folder");
  }
  return Status::Ok();
}

Status WriteCredentials(const std::filesystem::path& path, const s3::Credentials& key, Disk& disk) {
  ENAMEL_RETURN_IF_ERROR(disk.MakeFolder(path.parent_path()));
  const json::object document = {{"version", kDatabaseVersion},
                                 {"access_key", key.access_key},
                                 {"secret_key", key.secret_key}};
  return disk.Replace(path, AsBytes(json::serialize(document)));
}

Status WriteDatabaseFile(const std::filesystem::path& folder, const DatabaseFile& file,
                         Disk& disk) {
  ENAMEL_RETURN_IF_ERROR(MayKeepRowsIn(folder, file));
  json::object document = {{"format", kDatabaseFormat},
                           {"version", kDatabaseVersion},
                           {"server", file.server},
                           {"schema", file.schema}};
  if (file.blobs) document["blobs"] = ObjectOf(*file.blobs);
  if (file.keys) {
    json::object keys = ObjectOf(file.keys->bucket);
    keys["master_key_file"] = file.keys->master_key_file;
    document["keys"] = std::move(keys);
  }
  return disk.Replace(folder / kDatabaseFile, AsBytes(json::serialize(document)));
}

}  // namespace enamel::server
