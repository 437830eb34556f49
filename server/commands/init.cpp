#include "server/commands/init.h"

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
  AddIdentity(cmd, options.identity);
  cmd->footer(
      "To run several servers of one school, make the first with --database, --s3-endpoint,\n"
      "--s3-bucket, --key-bucket and --master-key. Copy station.crt, station.key and ticket.key\n"
      "from its data folder, and the master key, to the next machine, and name them there:\n\n"
      "  enamel-server init --data /var/lib/enamel \\\n"
      "    --database \"postgresql://enamel@db/school?sslmode=verify-full\" \\\n"
      "    --s3-endpoint https://s3.example.org --s3-bucket school --key-bucket school-keys \\\n"
      "    --master-key /etc/enamel/master.key --identity /etc/enamel/identity");
}

}  // namespace enamel::server::app
