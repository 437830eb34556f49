#include "server/storage/verify/manifest.h"

#include <algorithm>
#include <boost/json.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "common/base/file.h"
#include "common/base/hex.h"
#include "common/base/uuid.h"
#include "server/storage/audit/audit_row.h"
#include "server/storage/folder/folder_lock.h"

namespace enamel::server {
namespace {

namespace json = boost::json;

constexpr std::string_view kFormat = "enamel-server-backup";
constexpr int64_t kVersion = 1;
// Room for more than two million files.
constexpr size_t kMaxBytes = size_t{512} << 20;

Status Bad(const std::string& member, const std::string& expected) {
  return Status(Code::kInvalidInput, "manifest.json: expected " + expected + " as " + member,
                member);
}

// Nothing else is ever written to a data folder by a restore.
bool MayBeInBackup(std::string_view path) {
  if (path == "enamel.db") return true;
  for (std::string_view name : kIdentityFiles) {
    if (path == name) return true;
  }
  auto is_hash = [](std::string_view text) {
    return text.size() == 64 && Sha256::FromHex(text).ok();
  };
  if (path.starts_with("blobs/")) {
    std::string_view rest = path.substr(6);
    return rest.size() == 67 && rest[2] == '/' && is_hash(rest.substr(3)) &&
           rest.substr(0, 2) == rest.substr(3, 2);
  }
  if (path.starts_with("keyring/gone/")) return is_hash(path.substr(13));
  return path.starts_with("keyring/") && path.ends_with(".key") && path.size() == 8 + 36 + 4 &&
         Uuid::Parse(path.substr(8, 36)).ok();
}

Result<uint64_t> Number(const json::object& from, const char* name) {
  const json::value* value = from.if_contains(name);
  json::error_code error;
  uint64_t out = value != nullptr ? value->to_number<uint64_t>(error) : 0;
  if (value == nullptr || error) return Bad(name, "a number that is not negative");
  return out;
}

Result<std::string> Text(const json::object& from, const char* name) {
  const json::value* value = from.if_contains(name);
  if (value == nullptr || !value->is_string()) return Bad(name, "a text");
  return std::string(value->as_string());
}

Result<Manifest::File> FileOf(const json::value& value) {
  if (!value.is_object()) return Bad("files", "objects");
  auto path = Text(value.as_object(), "path"), hash = Text(value.as_object(), "sha256");
  auto bytes = Number(value.as_object(), "bytes");
  ENAMEL_RETURN_IF_ERROR(path.status());
  ENAMEL_RETURN_IF_ERROR(hash.status());
  ENAMEL_RETURN_IF_ERROR(bytes.status());
  auto sha256 = Sha256::FromHex(*hash);
  if (!sha256.ok()) return Bad("sha256", "64 hexadecimal digits");
  if (!MayBeInBackup(*path)) {
    return Bad("files.path",
               "a file of a backup (schemas/backup.md), not \"" + path->substr(0, 200) + "\",");
  }
  return Manifest::File{*path, *bytes, *sha256};
}

Status ReadCounts(const json::object& root, Manifest& out) {
  const json::value* counts = root.if_contains("counts");
  if (counts == nullptr || !counts->is_object()) return Bad("counts", "an object");
  auto people = Number(counts->as_object(), "people");
  auto attempts = Number(counts->as_object(), "attempts");
  auto ticks = Number(counts->as_object(), "ticks");
  for (const auto* number : {&people, &attempts, &ticks}) {
    if (!number->ok()) return number->status();
  }
  out.people = *people;
  out.attempts = *attempts;
  out.ticks = *ticks;
  return Status::Ok();
}

Status ReadFiles(const json::object& root, Manifest& out) {
  const json::value* files = root.if_contains("files");
  if (files == nullptr || !files->is_array()) return Bad("files", "an array");
  for (const json::value& value : files->as_array()) {
    ENAMEL_ASSIGN_OR_RETURN(auto file, FileOf(value));
    // In order, so that once is seen at once: a path listed twice could have two hashes.
    if (!out.files.empty() && out.files.back().path >= file.path) {
      return Bad("files", "paths in order, each once,");
    }
    out.files.push_back(std::move(file));
  }
  return Status::Ok();
}

Result<AuditHead> HeadOf(const json::value& value) {
  if (!value.is_object()) return Bad("trail", "objects");
  const json::object& from = value.as_object();
  AuditHead out;
  ENAMEL_ASSIGN_OR_RETURN(const auto chain, Text(from, "chain"));
  ENAMEL_ASSIGN_OR_RETURN(out.number, Number(from, "rows"));
  ENAMEL_ASSIGN_OR_RETURN(const auto last, Text(from, "last"));
  ENAMEL_ASSIGN_OR_RETURN(const auto hash, Text(from, "sha256"));
  ENAMEL_ASSIGN_OR_RETURN(const auto signature, Text(from, "signature"));
  ENAMEL_ASSIGN_OR_RETURN(out.chain, Uuid::Parse(chain));
  ENAMEL_ASSIGN_OR_RETURN(out.last_id, Uuid::Parse(last));
  ENAMEL_ASSIGN_OR_RETURN(out.hash, Sha256::FromHex(hash));
  const auto bytes = FromHex(signature);
  if (!bytes.ok() || bytes->size() != out.signature.size() || out.number == 0) {
    return Bad("trail", "the ends of the audit trail (schemas/backup.md)");
  }
  std::ranges::copy(*bytes, out.signature.begin());
  return out;
}

Status ReadTrail(const json::object& root, Manifest& out) {
  const json::value* trail = root.if_contains("trail");
  if (trail == nullptr || !trail->is_array()) return Bad("trail", "an array");
  for (const json::value& value : trail->as_array()) {
    ENAMEL_ASSIGN_OR_RETURN(auto head, HeadOf(value));
    out.trail.push_back(head);
  }
  return Status::Ok();
}

}  // namespace

std::string ToJson(const Manifest& manifest) {
  json::array files;
  for (const Manifest::File& file : manifest.files) {
    files.push_back({{"path", file.path}, {"bytes", file.bytes}, {"sha256", file.hash.Hex()}});
  }
  json::array trail;
  for (const AuditHead& head : manifest.trail) {
    trail.push_back({{"chain", head.chain.Text()},
                     {"rows", head.number},
                     {"last", head.last_id.Text()},
                     {"sha256", head.hash.Hex()},
                     {"signature", ToHex(head.signature)}});
  }
  return json::serialize(json::object{{"format", kFormat},
                                      {"version", kVersion},
                                      {"created_ms", manifest.created_ms},
                                      {"software", manifest.software},
                                      {"schema", manifest.schema},
                                      {"keyring", manifest.keyring_inside ? "inside" : "apart"},
                                      {"counts",
                                       {{"people", manifest.people},
                                        {"attempts", manifest.attempts},
                                        {"ticks", manifest.ticks}}},
                                      {"trail", std::move(trail)},
                                      {"files", std::move(files)}}) +
         "\n";
}

Result<Manifest> ManifestFromJson(std::string_view text) {
  json::error_code error;
  json::value value = json::parse({text.data(), text.size()}, error);
  if (error || !value.is_object()) {
    return Status(Code::kInvalidInput, "manifest.json: expected one JSON object" +
                                           (error ? ": " + error.message() : std::string()));
  }
  const json::object& root = value.as_object();
  auto format = Text(root, "format"), software = Text(root, "software"),
       keyring = Text(root, "keyring");
  auto version = Number(root, "version"), created = Number(root, "created_ms"),
       schema = Number(root, "schema");
  if (!format.ok() || *format != kFormat) return Bad("format", "\"" + std::string(kFormat) + "\"");
  ENAMEL_RETURN_IF_ERROR(version.status());
  if (*version != kVersion) {
    return Status(Code::kVersion, "a backup of version " + std::to_string(*version) +
                                      ", this enamel-server restores " + std::to_string(kVersion) +
                                      "; run the one that made it");
  }
  for (const auto* part : {&software, &keyring}) {
    if (!part->ok()) return part->status();
  }
  for (const auto* part : {&created, &schema}) {
    if (!part->ok()) return part->status();
  }
  if (*keyring != "inside" && *keyring != "apart") return Bad("keyring", "inside or apart");
  Manifest out;
  out.created_ms = static_cast<int64_t>(*created);
  out.software = *software;
  out.schema = static_cast<int>(*schema);
  out.keyring_inside = *keyring == "inside";
  ENAMEL_RETURN_IF_ERROR(ReadCounts(root, out));
  ENAMEL_RETURN_IF_ERROR(ReadTrail(root, out));
  ENAMEL_RETURN_IF_ERROR(ReadFiles(root, out));
  return out;
}

Result<Manifest> ReadManifest(const std::filesystem::path& backup) {
  auto text = ReadFile(backup / kManifestName, kMaxBytes);
  if (!text.ok() && text.status().code() == Code::kNotFound) {
    return Status(Code::kInvalidInput,
                  backup.string() +
                      " has no manifest.json: it is no backup, or one that was "
                      "not finished; name another");
  }
  ENAMEL_RETURN_IF_ERROR(text.status());
  return ManifestFromJson(AsText(*text));
}

namespace {

// Where a database was. The ids of its trail's rows rise, also after a clock was set back, and rise
// again after a restore. The clock alone decides nothing.
std::tuple<Uuid, uint64_t, int64_t> PositionOf(const Manifest& manifest) {
  Uuid last;
  uint64_t rows = 0;
  for (const AuditHead& head : manifest.trail) {
    last = std::max(last, head.last_id);
    rows += head.number;
  }
  return {last, rows, manifest.created_ms};
}

}  // namespace

Result<std::filesystem::path> NewestBackup(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  std::optional<std::pair<std::tuple<Uuid, uint64_t, int64_t>, fs::path>> newest;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() == kPartSuffix) continue;
    const auto manifest = ReadManifest(it->path());
    if (!manifest.ok()) continue;
    std::pair found(PositionOf(*manifest), it->path());
    if (!newest || *newest < found) newest = std::move(found);
  }
  if (error) {
    return Status(Code::kStorage, "cannot read " + folder.string() + ": " + error.message());
  }
  if (newest) return newest->second;
  return Status(Code::kNotFound, "there is no finished backup in " + folder.string() +
                                     ": no folder in it has a manifest.json; make a backup");
}

}  // namespace enamel::server
