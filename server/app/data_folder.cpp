#include "server/app/data_folder.h"

#include "common/base/file.h"
#include "common/net/certificate.h"
#include "common/protocol/release.h"
#include "server/app/school_folder.h"
#include "server/storage/engine/server_identity.h"
#include "server/storage/folder/data_folder.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/folder/ticket_key.h"
#include "server/storage/open_store.h"
#include "server/storage/store.h"

namespace enamel::server::app {
namespace {

constexpr size_t kMaxIdentityBytes = 1 << 20;

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

std::string SoftwareName() { return "enamel-server " + std::string(protocol::ThisRelease()); }

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
    ENAMEL_RETURN_IF_ERROR(mine.status());
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
