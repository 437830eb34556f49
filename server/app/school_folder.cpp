#include "server/app/school_folder.h"

#include <sodium.h>

#include <array>
#include <boost/json.hpp>

#include "common/base/file.h"
#include "server/storage/folder/data_folder.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/open_store.h"
#include "server/storage/school/delete_store.h"

namespace enamel::server::app {
namespace {

namespace fs = std::filesystem;

// The school's ticket key: BLAKE2b of this text and the school's id, under the secret seed of the
// installation's. Each server derives the same key. No school can derive the installation's from
// it, and a school added again under an old name gets another.
Result<trace::KeyPair> SchoolKey(const fs::path& installation, const Uuid& id) {
  constexpr std::string_view kLabel = "enamel.school-key.v1";
  ENAMEL_ASSIGN_OR_RETURN(const auto own, ReadTicketKey(installation));
  Bytes told(kLabel.begin(), kLabel.end());
  told.insert(told.end(), id.bytes.begin(), id.bytes.end());
  std::array<uint8_t, crypto_sign_SEEDBYTES> seed;
  // Ed25519's secret key begins with its seed.
  crypto_generichash(seed.data(), seed.size(), told.data(), told.size(), own.secret_key.data(),
                     crypto_sign_SEEDBYTES);
  const trace::KeyPair keys = trace::KeyPairFromSeed(seed);
  sodium_memzero(seed.data(), seed.size());
  return keys;
}

}  // namespace

fs::path SchoolFolder(const fs::path& installation, const std::string& name) {
  return installation / "schools" / name;
}

std::optional<fs::path> InstallationOf(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder / kSchoolFile, error)) return std::nullopt;
  // The given path: schools/NAME may be a link to another disk.
  fs::path path = fs::absolute(folder, error).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();  // a slash at the end
  return path.parent_path().parent_path();
}

DatabaseFile SchoolDatabase(const fs::path& installation, const DatabaseFile& its,
                            const std::string& name) {
  // A relative name in the file is relative to that file.
  const auto from_there = [&](std::string& path) {
    if (!path.empty()) path = fs::absolute(installation / path).lexically_normal().string();
  };
  const auto below = [&](PlaceInS3& place) {
    place.prefix += "schools/" + name + "/";
    from_there(place.ca_file);
    from_there(place.credentials_file);
  };
  DatabaseFile out = its;
  out.schema += "_" + name;
  if (out.blobs) below(*out.blobs);
  if (out.keys) {
    below(out.keys->bucket);
    from_there(out.keys->master_key_file);
  }
  return out;
}

namespace {

Status KeepDatabaseFile(const fs::path& folder, const DatabaseFile& wanted) {
  Disk& disk = SystemDisk();
  const auto kept = ReadDatabaseFile(folder);
  const bool same = kept.ok() && *kept && **kept == wanted;
  if (same) return Status::Ok();
  // The installation's has changed, or this one is damaged. It has nothing that is not made of the
  // other.
  ENAMEL_RETURN_IF_ERROR(disk.Remove(folder / kDatabaseFile));
  return WriteDatabaseFile(folder, wanted, disk);
}

bool HasRowsIn(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "enamel.db", error);
}

Status MustBeThere(const fs::path& folder, const SchoolRow& row) {
  if (HasRowsIn(folder)) return Status::Ok();
  return {Code::kNotFound, "the data of school " + row.name + " is not in " + folder.string() +
                               "; bring that folder back (mount it, or restore a backup or an "
                               "export of the school into it)"};
}

Status MustNotBeThere(const fs::path& folder) {
  if (!HasRowsIn(folder)) return Status::Ok();
  return {Code::kConflict, "expected no data in " + folder.string() +
                               ", found a school's; move that folder away, or delete it"};
}

}  // namespace

Result<ServerIdentity> EnsureSchoolFolder(const fs::path& installation, const SchoolRow& row,
                                          SchoolData data) {
  const fs::path folder = SchoolFolder(installation, row.name);
  Disk& disk = SystemDisk();
  ENAMEL_ASSIGN_OR_RETURN(const auto database, ReadDatabaseFile(installation));
  if (!database) {
    ENAMEL_RETURN_IF_ERROR(data == SchoolData::kMake ? MustNotBeThere(folder)
                                                     : MustBeThere(folder, row));
  }
  ENAMEL_RETURN_IF_ERROR(MakeDataFolder(folder, disk, /*restoring=*/false));
  const std::string document =
      boost::json::serialize(boost::json::object{
          {"format", "enamel-school"}, {"version", 1}, {"name", row.name}, {"id", row.id.Text()}}) +
      "\n";
  constexpr size_t kMaxDocument = 4096;
  const auto kept_document = ReadFile(folder / kSchoolFile, kMaxDocument);
  if (!kept_document.ok() || AsText(*kept_document) != document) {
    ENAMEL_RETURN_IF_ERROR(disk.Replace(folder / kSchoolFile, AsBytes(document)));
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto key, SchoolKey(installation, row.id));
  const auto kept = ReadTicketKey(folder);
  // The key of an earlier school of this name: with PostgreSQL nothing else of it is left here, and
  // a new school has no key yet.
  const bool others = kept.ok() && kept->secret_key != key.secret_key &&
                      (database.has_value() || data == SchoolData::kMake);
  if (others || kept.status().code() == Code::kNotFound) {
    ENAMEL_RETURN_IF_ERROR(disk.Replace(TicketKeyPath(folder), key.secret_key));
  }
  if (database) {
    ENAMEL_RETURN_IF_ERROR(
        KeepDatabaseFile(folder, SchoolDatabase(installation, *database, row.name)));
  }
  return EnsureIdentity(folder);
}

Result<OpenedSchool> OpenSchool(const fs::path& installation, const SchoolRow& row,
                                StoreOptions options) {
  OpenedSchool out;
  ENAMEL_ASSIGN_OR_RETURN(out.identity, EnsureSchoolFolder(installation, row, SchoolData::kExpect));
  options.folder = SchoolFolder(installation, row.name);
  ENAMEL_ASSIGN_OR_RETURN(const auto database, ReadDatabaseFile(options.folder));
  if (database) {
    ENAMEL_ASSIGN_OR_RETURN(const bool there,
                            HasServers({database->server, database->schema, {options.folder}}));
    if (!there) {
      return Status(Code::kNotFound, "the rows of school " + row.name + " are not in schema " +
                                         database->schema + " of the database; bring them back");
    }
  }
  ENAMEL_ASSIGN_OR_RETURN(out.store, OpenStore(options));
  return out;
}

Status DeleteSchool(const fs::path& installation, const SchoolRow& row) {
  const fs::path folder = SchoolFolder(installation, row.name);
  // On this machine it may never have been.
  ENAMEL_RETURN_IF_ERROR(SystemDisk().MakeFolder(folder));
  ENAMEL_ASSIGN_OR_RETURN(auto database, ReadDatabaseFile(installation));
  if (database) database = SchoolDatabase(installation, *database, row.name);
  return DeleteStore(folder, database);
}

Status ForgetSchool(const fs::path& installation, const std::string& name) {
  ENAMEL_ASSIGN_OR_RETURN(const auto database, ReadDatabaseFile(installation));
  if (!database || !database->blobs || !database->keys) return Status::Ok();
  const fs::path folder = SchoolFolder(installation, name);
  std::error_code error;
  fs::remove_all(folder, error);
  if (!error) return Status::Ok();
  return {Code::kStorage, "cannot delete " + folder.string() + ": " + error.message()};
}

}  // namespace enamel::server::app
