#include "server/commands/init.h"

#include <iostream>

#include "server/app/data_folder.h"
#include "server/app/places.h"
#include "server/commands/command_line.h"
#include "server/commands/say.h"
#include "server/storage/engine/server_identity.h"
#include "server/storage/folder/database_file.h"
#include "server/storage/folder/disk.h"
#include "server/storage/folder/store_options.h"
#include "server/storage/open_store.h"
#include "server/storage/store.h"

namespace enamel::server::app {
namespace {

struct InitCommand {
  std::filesystem::path data;
  Places places;
  std::string access_key;  // of the S3 store, whose secret is on standard input; empty: none
  std::filesystem::path identity;  // of another server; empty: its own
};

// Tries the stores with an access key that is not in any file yet, and keeps it in s3.json if they
// take it.
Status TryWithKey(const InitCommand& command, const DatabaseFile& file) {
  if (command.access_key.empty()) return TryStores(command.data, file);
  s3::Credentials key{.access_key = command.access_key, .secret_key = {}};
  if (!std::getline(std::cin, key.secret_key) || key.secret_key.empty()) {
    return Status(Code::kInvalidInput,
                  "expected the secret of the access key as one line on standard input, found "
                  "nothing",
                  "s3-access-key");
  }
  const std::filesystem::path path = file.blobs->credentials_file;
  ENAMEL_RETURN_IF_ERROR(WriteCredentials(path, key, SystemDisk()));
  const Status tried = TryStores(command.data, file);
  if (!tried.ok()) {
    std::error_code error;
    std::filesystem::remove(path, error);
    std::filesystem::remove(command.data, error);  // unless there is something else in it
  }
  return tried;
}

Status Init(const InitCommand& command) {
  Places places = command.places;
  if (!command.access_key.empty()) places.blobs.credentials_file = command.data / "s3.json";
  ENAMEL_ASSIGN_OR_RETURN(const auto file, FileOf(places));
  if (file) {
    ENAMEL_RETURN_IF_ERROR(MayKeepRowsIn(command.data, *file));
    ENAMEL_RETURN_IF_ERROR(TryWithKey(command, *file));
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

}  // namespace

Status InitData(const std::filesystem::path& folder) {
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenStore({folder}));
  ENAMEL_ASSIGN_OR_RETURN(auto identity, EnsureMatchingIdentity(folder, store->identity));
  Say("data folder {}, fingerprint {}\n", folder.string(), identity.fingerprint.Hex());
  return Status::Ok();
}

void DeclareInit(CommandGroup root) {
  auto [cmd, options] = Declare<InitCommand>(
      root, "init", "Make a data folder, to run commands on it before the first serve", Init);
  AddData(cmd, options.data);
  AddPlaces(cmd, options.places);
  cmd->add_option("--s3-access-key", options.access_key,
                  "Access key of the S3 store, whose secret is the first line of standard input; "
                  "both are kept in s3.json of the data folder")
      ->needs(cmd->get_option("--s3-endpoint"))
      ->excludes(cmd->get_option("--s3-credentials"));
  AddIdentity(cmd, options.identity);
  cmd->footer(
      "To run several servers of one school, make the first with --database, --s3-endpoint,\n"
      "--s3-bucket, --s3-access-key, --key-bucket and --master-key. Copy station.crt, station.key\n"
      "and ticket.key from its data folder, and the master key, to the next machine, and name\n"
      "them there:\n\n"
      "  enamel-server init --data /var/lib/enamel \\\n"
      "    --database \"postgresql://enamel@db/school?sslmode=verify-full\" \\\n"
      "    --s3-endpoint https://s3.example.org --s3-bucket school --key-bucket school-keys \\\n"
      "    --master-key /etc/enamel/master.key --identity /etc/enamel/identity");
}

}  // namespace enamel::server::app
