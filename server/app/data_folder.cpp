#include "server/app/data_folder.h"

#include "common/base/file.h"
#include "common/net/certificate.h"
#include "server/app/command_line.h"
#include "server/app/places.h"
#include "server/app/say.h"
#include "server/app/school_folder.h"
#include "server/storage/engine/server_identity.h"
#include "server/storage/folder/data_folder.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/disk.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/open_store.h"
#include "server/storage/store.h"

namespace enamel::server::app {
namespace {

constexpr size_t kMaxIdentityBytes = 1 << 20;

struct InitCommand {
  std::filesystem::path data;
  Places places;
  std::filesystem::path identity;  // of another server; empty: its own
};

Status Init(const InitCommand& command) {
  ENAMEL_ASSIGN_OR_RETURN(const auto file, FileOf(command.places));
  if (file) {
    ENAMEL_RETURN_IF_ERROR(MayKeepRowsIn(command.data, *file));
    ENAMEL_RETURN_IF_ERROR(TryStores(command.data, *file));
  }
  if (!command.identity.empty()) {
    ENAMEL_RETURN_IF_ERROR(TakeIdentity(command.data, command.identity));
  }
  if (file) {
    ENAMEL_ASSIGN_OR_RETURN(const auto options, FirstOptions(command.data, *file));
    // Before writing the file: a folder must not be bound to an unreachable server, and one with
    // other content must not be taken for ours.
    if (auto opened = OpenPostgresStore(options); !opened.ok()) return opened.status();
    ENAMEL_RETURN_IF_ERROR(WriteDatabaseFile(command.data, *file, SystemDisk()));
  }
  return InitData(command.data);
}

// Creates a missing certificate; returns its fingerprint.
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

Status TakeIdentity(const std::filesystem::path& folder, const std::filesystem::path& from,
                    bool moving) {
  std::vector<std::pair<std::filesystem::path, Bytes>> missing;
  for (const char* name : kIdentityFiles) {
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
  // Checks the folder first: no key is written where others may read it.
  if (!missing.empty()) {
    ENAMEL_RETURN_IF_ERROR(MakeDataFolder(folder, SystemDisk(), /*restoring=*/moving));
  }
  for (const auto& [path, content] : missing) {
    ENAMEL_RETURN_IF_ERROR(SystemDisk().Replace(path, content));
  }
  return Status::Ok();
}

Result<ServerIdentity> EnsureIdentity(const std::filesystem::path& folder) {
  ServerIdentity identity;
  const std::filesystem::path known_by = InstallationOf(folder).value_or(folder);
  identity.certificate = known_by / "station.crt";
  identity.private_key = known_by / "station.key";
  std::error_code error;
  if (known_by != folder && !std::filesystem::exists(identity.certificate, error)) {
    return Status(Code::kNotFound,
                  "expected the installation of this school, with its station.crt, in " +
                      known_by.string() +
                      "; name the school's folder as INSTALLATION/schools/NAME, also where that is "
                      "a link");
  }
  ENAMEL_ASSIGN_OR_RETURN(
      auto fingerprint,
      EnsureCertificate(identity.certificate, identity.private_key, "enamel-server"));
  identity.fingerprint = fingerprint;
  ENAMEL_ASSIGN_OR_RETURN(auto keys, EnsureTicketKey(folder, SystemDisk()));
  identity.ticket_key = keys;
  return identity;
}

Result<ServerIdentity> EnsureMatchingIdentity(const std::filesystem::path& folder,
                                              ServerIdentityRows& identity_rows) {
  std::error_code error;
  if (!std::filesystem::exists(folder / "station.crt", error)) {
    // Before making one that the check would refuse.
    ENAMEL_RETURN_IF_ERROR(identity_rows.MatchIdentity(ServerPart::kStationCertificate, {}));
  }
  ENAMEL_ASSIGN_OR_RETURN(auto identity, EnsureIdentity(folder));
  ENAMEL_RETURN_IF_ERROR(
      identity_rows.MatchIdentity(ServerPart::kStationCertificate, identity.fingerprint));
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
  ENAMEL_ASSIGN_OR_RETURN(auto identity, EnsureMatchingIdentity(folder, store->identity));
  Say("data folder {}, fingerprint {}\n", folder.string(), identity.fingerprint.Hex());
  return Status::Ok();
}

void DeclareInit(CommandGroup root) {
  auto [cmd, options] = Declare<InitCommand>(
      root, "init", "Make a data folder, for commands that come before the first serve", Init);
  AddData(cmd, options.data);
  AddPlaces(cmd, options.places);
  AddIdentity(cmd, options.identity);
  cmd->footer(
      "Several servers of one school: the first is made with --database, --s3-endpoint,\n"
      "--s3-bucket, --key-bucket and --master-key. Copy station.crt, station.key and ticket.key\n"
      "of its data folder and the master key to the next machine, and name them there:\n\n"
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
  StoreOptions options;
  options.folder = folder;
  return OpenStore(options);
}

}  // namespace enamel::server::app
