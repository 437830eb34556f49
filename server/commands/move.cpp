#include "server/commands/move.h"

#include <boost/json.hpp>

#include "common/base/counted.h"
#include "common/program/output.h"
#include "server/app/data_folder.h"
#include "server/commands/command_line.h"
#include "server/commands/console_progress.h"
#include "server/commands/say.h"
#include "server/storage/audit/audit_trail.h"
#include "server/storage/folder/disk.h"
#include "server/storage/folder/folder_lock.h"
#include "server/storage/move/move.h"
#include "server/storage/open_store.h"

namespace enamel::server::app {
namespace {

namespace json = boost::json;

// Says where rows, blobs and keys are to be, and makes the folder this server and no other.
Status Prepare(const MoveCommand& command) {
  ENAMEL_ASSIGN_OR_RETURN(const auto file, FileOf(command.places));
  if (file) {
    // Whether it can be reached, before creating a folder.
    ENAMEL_RETURN_IF_ERROR(HasServers({file->server, file->schema, {command.to}}).status());
    ENAMEL_RETURN_IF_ERROR(TryStores(command.to, *file));
  }
  ENAMEL_RETURN_IF_ERROR(BeginMove(command.data, command.to, SystemDisk()));
  ENAMEL_RETURN_IF_ERROR(TakeIdentity(command.to, command.data, /*moving=*/true));
  if (!file) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(FirstOptions(command.to, *file).status());
  return WriteDatabaseFile(command.to, *file, SystemDisk());
}

json::object JsonOf(const MoveReport& report) {
  json::array tables, missing;
  for (const TableDigest& table : report.tables) {
    tables.push_back({{"table", table.table}, {"rows", table.rows}, {"sha256", table.hash.Hex()}});
  }
  for (const Sha256& hash : report.missing) missing.emplace_back(hash.Hex());
  return {{"tables", std::move(tables)},         {"blobs", report.blobs}, {"bytes", report.bytes},
          {"there_before", report.there_before}, {"keys", report.keys},   {"erased", report.erased},
          {"missing", std::move(missing)}};
}

}  // namespace

Status Move(const MoveCommand& command) {
  std::error_code error;
  if (std::filesystem::weakly_canonical(command.data, error) ==
      std::filesystem::weakly_canonical(command.to, error)) {
    return Status(Code::kInvalidInput, "expected another folder with --to than with --data", "to");
  }
  // That there is a school; brings an older database up to date. One with a mark of this move was
  // looked at before.
  if (!std::filesystem::exists(command.data / kMovedMark, error)) {
    ENAMEL_RETURN_IF_ERROR(OpenForCommand(command.data).status());
  }
  ENAMEL_RETURN_IF_ERROR(Prepare(command));
  // The progress line is wiped when its object goes, so it goes before anything is said.
  Result<MoveReport> report = [&] {
    ConsoleProgress progress;
    return MoveSchool({command.data, command.to, command.accept_damage, Telling(progress)});
  }();
  ENAMEL_RETURN_IF_ERROR(report.status());
  uint64_t rows = 0;
  for (const TableDigest& table : report->tables) rows += table.rows;
  Say("moved: {} of {}, {} ({:.1f} MiB{}), {}; all read back and compared\n", Counted(rows, "row"),
      Counted(report->tables.size(), "table"), Counted(report->blobs, "blob"),
      static_cast<double>(report->bytes) / (1 << 20),
      report->there_before == 0 ? std::string()
                                : fmt::format(", {} were there", report->there_before),
      Counted(report->keys, "key"));
  for (const Sha256& hash : report->missing) Say("missing or damaged: blob {}\n", hash.Hex());
  Say("start the server with --data {}; nothing was deleted in {}, which no server starts on now\n",
      command.to.string(), command.data.string());
  return program::WriteJsonFile(command.json, JsonOf(*report));
}

void DeclareMove(CommandGroup root) {
  auto [cmd, options] = Declare<MoveCommand>(
      root, "move", "Move a school to PostgreSQL and S3 stores, or back into a folder", Move);
  AddData(cmd, options.data)->description("Data folder of the school, as it is now");
  cmd->add_option("--to", options.to, "New data folder: absent or empty")->required();
  AddPlaces(cmd, options.places);
  cmd->add_flag("--accept-damage", options.accept_damage,
                "Leave out blobs that are missing or damaged, and list them");
  cmd->add_option("--json", options.json, "Write the outcome to this file");
  cmd->footer(
      "Stop every server of the school first. Everything is read back and compared by its hash.\n"
      "To continue an interrupted move, repeat the command. Nothing is deleted in the old "
      "place.\n\n"
      "  enamel-server move --data /var/lib/enamel --to /var/lib/enamel-cluster \\\n"
      "    --database \"postgresql://enamel@db/school?sslmode=verify-full\" \\\n"
      "    --s3-endpoint https://s3.example.org --s3-bucket school --key-bucket school-keys \\\n"
      "    --master-key /etc/enamel/master.key\n"
      "  enamel-server move --data /var/lib/enamel-cluster --to /var/lib/enamel-back");
}

}  // namespace enamel::server::app
