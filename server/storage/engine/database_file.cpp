#include "server/storage/engine/database_file.h"

#include <boost/json.hpp>

#include "common/base/file.h"

namespace enamel::server {
namespace {

namespace json = boost::json;

constexpr int64_t kVersion = 1;
constexpr size_t kMaxBytes = 64 << 10;

Status Bad(const std::filesystem::path& path, const std::string& found) {
  return Status(Code::kInvalidInput,
                path.string() + ": expected {\"version\":1,\"server\":…,\"schema\":…}, found " +
                    found +
                    "; mend it, or make the folder anew with: enamel-server init --database");
}

}  // namespace

Result<std::optional<DatabaseFile>> ReadDatabaseFile(const std::filesystem::path& folder) {
  const auto path = folder / kDatabaseFile;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return std::optional<DatabaseFile>();
  ENAMEL_ASSIGN_OR_RETURN(const Bytes bytes, ReadFile(path, kMaxBytes));
  boost::system::error_code bad;
  const json::value document = json::parse(AsText(bytes), bad);
  if (bad || !document.is_object()) return Bad(path, "no JSON object");
  const json::object& all = document.get_object();
  const json::value* version = all.if_contains("version");
  if (version == nullptr || !version->is_int64()) return Bad(path, "no version");
  if (version->get_int64() != kVersion) {
    return Status(Code::kVersion, path.string() + " has version " +
                                      std::to_string(version->get_int64()) +
                                      ", this enamel-server knows 1; run the newer one");
  }
  DatabaseFile out;
  for (auto [name, into] : {std::pair{"server", &out.server}, std::pair{"schema", &out.schema}}) {
    const json::value* value = all.if_contains(name);
    if (value == nullptr || !value->is_string() || value->get_string().empty())
      return Bad(path, std::string("no text as ") + name);
    *into = value->get_string();
  }
  return std::optional<DatabaseFile>(std::move(out));
}

Status MustHaveRowsInFolder(const std::filesystem::path& folder, const std::string& command) {
  ENAMEL_ASSIGN_OR_RETURN(const auto database, ReadDatabaseFile(folder));
  if (!database) return Status::Ok();
  return Status(Code::kConflict, "expected rows in " + (folder / "enamel.db").string() +
                                     ", found that they are in PostgreSQL (database.json), which " +
                                     command + " does not read; copy schema " + database->schema +
                                     " with pg_dump, and after it the folder");
}

Status MayKeepRowsIn(const std::filesystem::path& folder, const DatabaseFile& file) {
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
  return Status::Ok();
}

Status WriteDatabaseFile(const std::filesystem::path& folder, const DatabaseFile& file,
                         Disk& disk) {
  ENAMEL_RETURN_IF_ERROR(MayKeepRowsIn(folder, file));
  const json::object document = {
      {"version", kVersion}, {"server", file.server}, {"schema", file.schema}};
  return disk.Replace(folder / kDatabaseFile, AsBytes(json::serialize(document)));
}

}  // namespace enamel::server
