#include "server/app/data_folder.h"

#include "common/base/file.h"
#include "common/net/certificate.h"
#include "server/app/command_line.h"
#include "server/app/say.h"
#include "server/storage/engine/database_file.h"
#include "server/storage/engine/ticket_key.h"
#include "server/storage/sqlite_store.h"

namespace enamel::server::app {
namespace {

struct InitCommand {
  std::filesystem::path data;
  std::string database;  // of PostgreSQL; empty: SQLite in the folder
  std::string schema = "enamel";
};

Status Init(const InitCommand& command) {
  if (!command.database.empty()) {
    const DatabaseFile file{command.database, command.schema};
    ENAMEL_RETURN_IF_ERROR(MayKeepRowsIn(command.data, file));
    // Before the file says so: a folder must not be bound to a server that cannot be reached, nor
    // one that holds other things be taken for ours.
    if (auto opened = OpenPostgresStore({file.server, file.schema, {command.data}}); !opened.ok())
      return opened.status();
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
  ENAMEL_ASSIGN_OR_RETURN(auto identity, EnsureIdentity(folder));
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
