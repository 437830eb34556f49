#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"

// The commands with which a school keeps its data: backup, restore, verify, retention. Each prints
// progress to standard error, its outcome to standard output and, where asked, as JSON to a file.
namespace enamel::server::app {

struct BackupCommand {
  std::filesystem::path data, target, keyring, json;
  bool copy = false;
  std::filesystem::path into{};  // instead of `target`: a folder in this one, named by the time
  // For the server that started it (jobs/backup_run.h), which notes in the audit trail how it ends:
  // prints one JSON object a line, {"phase", "done", "all"} on its way, {"files", "bytes",
  // "missing"} or {"problem"} last. Ends with the server.
  bool report = false;
};
// Notes in the audit trail that it was made, or why not. Errors: those of BackUp
// (storage/backup/backup.h); kStorage also when blobs were missing or damaged and all else was
// backed up.
Status Backup(const BackupCommand& command);
// The installation's school into INTO/TIME, each other into INTO/schools/NAME/TIME. A school whose
// backup fails does not keep the next from theirs. Errors: the first that failed.
Status BackUpSchools(const BackupCommand& command);

struct RestoreCommand {
  std::filesystem::path backup, data, json;
  std::vector<std::filesystem::path> keyrings;
  bool accept_damage = false;
  std::filesystem::path newest{};  // instead of `backup`: the newest in this folder
  // For the server's restore drill (jobs/backup_run.h), which notes how it ends: as
  // BackupCommand::report, {"files", "bytes", "findings"} or {"problem"} last. Has no effect on
  // whatever else this machine does.
  bool report = false;
};
// Errors: those of Restore; kStorage also when the restored data disagrees with itself.
Status RestoreBackup(const RestoreCommand& command);

struct VerifyCommand {
  std::filesystem::path folder, keyring, json, since;
  bool is_backup = false;          // `folder` must be one
  std::filesystem::path newest{};  // instead of `folder`: the newest backup in this folder
};
// Errors: those of Verify; kStorage when anything disagrees, after all of it was printed.
Status VerifyFolder(const VerifyCommand& command);

// No `what`: shows the rules and the data they apply to now.
struct RetentionCommand {
  std::filesystem::path data;
  std::string what;         // sets the rule for this …
  std::optional<int> days;  // … to so many days, 0 takes it away; both or neither
  bool apply = false;
};
Status Retention(const RetentionCommand& command);

struct CommandGroup;
// On the command line (command_line.h), by subject.
void DeclareBackup(CommandGroup root);
void DeclareRetention(CommandGroup root);

}  // namespace enamel::server::app
