#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "common/base/result.h"
#include "server/app/data_folder.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/people/school_list.h"
#include "server/storage/store.h"

// Where an installation's other schools are: INSTALLATION/schools/NAME, each a data folder of its
// own. With PostgreSQL its tables are in a schema of their own, its blobs and keys have a prefix of
// their own. All its stations know the server by the installation's certificate; its tickets,
// results and audit trail are signed with a key of its own. Source: schemas/schools.md.
namespace enamel::server::app {

inline constexpr char kSchoolFile[] = "school.json";

std::filesystem::path SchoolFolder(const std::filesystem::path& installation,
                                   const std::string& name);
// The installation that a folder's school is one of; none: the folder is an installation.
std::optional<std::filesystem::path> InstallationOf(const std::filesystem::path& folder);

// Where a school's rows, blobs and keys are, beside those of its installation.
DatabaseFile SchoolDatabase(const std::filesystem::path& installation, const DatabaseFile& its,
                            const std::string& name);

// Creates the missing parts of the school's folder on this machine, and returns the school's
// identity. With PostgreSQL the folder is the same on each server of the installation, and follows
// the installation's database.json. With SQLite the folder is the whole school: `make` it, or
// expect it with its rows. Errors: kNotFound (it is missing; says what to do), kConflict (`make`,
// and somebody's rows exist), kStorage, those of ReadDatabaseFile.
enum class SchoolData : uint8_t { kMake, kExpect };
Result<ServerIdentity> EnsureSchoolFolder(const std::filesystem::path& installation,
                                          const SchoolRow& row, SchoolData data);

// The store of an existing school. Errors: those of EnsureSchoolFolder and OpenStore; kNotFound
// (PostgreSQL has no such school).
struct OpenedSchool {
  ServerIdentity identity;
  std::unique_ptr<Store> store;
};
Result<OpenedSchool> OpenSchool(const std::filesystem::path& installation, const SchoolRow& row,
                                StoreOptions options);

// Deletes all that is a school's, with its folder here. Errors: those of DeleteStore.
Status DeleteSchool(const std::filesystem::path& installation, const SchoolRow& row);
// On a machine where another deleted it. Only where all that is in the folder is elsewhere too:
// with rows in PostgreSQL, blobs and keys in S3 stores.
Status ForgetSchool(const std::filesystem::path& installation, const std::string& name);

}  // namespace enamel::server::app
