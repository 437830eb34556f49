#include "server/commands/upkeep.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <boost/json.hpp>
#include <chrono>

#include "common/base/counted.h"
#include "common/base/unix_time.h"
#include "common/base/utf8.h"
#include "common/program/example.h"
#include "common/program/output.h"
#include "server/app/data_folder.h"
#include "server/app/school_folder.h"
#include "server/commands/command_line.h"
#include "server/commands/console_progress.h"
#include "server/commands/say.h"
#include "server/jobs/backup_run.h"
#include "server/storage/backup/backup.h"
#include "server/storage/verify/manifest.h"

namespace enamel::server::app {
namespace {

namespace json = boost::json;

// A damaged disk can make as many findings as there are blobs; the first screens say what kind they
// are.
constexpr size_t kShownFindings = 50;

std::string Mib(uint64_t bytes) {
  return fmt::format("{:.1f} MiB", static_cast<double>(bytes) / (1 << 20));
}

json::object JsonOf(const VerifyReport& report) {
  json::array findings, notes;
  for (const Finding& finding : report.findings) {
    findings.push_back({{"kind", finding.kind},
                        {"object", finding.object},
                        {"expected", finding.expected},
                        {"found", finding.found},
                        {"remedy", finding.remedy}});
  }
  for (const std::string& note : report.notes) notes.emplace_back(note);
  json::array trail;
  for (const AuditHead& head : report.trail) {
    trail.push_back(
        {{"chain", head.chain.Text()}, {"rows", head.number}, {"sha256", head.hash.Hex()}});
  }
  return {{"ok", report.findings.empty()},   {"backup", report.is_backup},
          {"schema", report.schema},         {"blobs", report.blobs},
          {"blob_bytes", report.blob_bytes}, {"unnamed_blobs", report.unnamed_blobs},
          {"people", report.people},         {"attempts", report.attempts},
          {"sealed", report.sealed},         {"chunks", report.chunks},
          {"ticks", report.ticks},           {"keys", report.keys},
          {"erased", report.erased},         {"results", report.results},
          {"audit_rows", report.audit_rows}, {"trail", std::move(trail)},
          {"decisions", report.decisions},   {"findings", std::move(findings)},
          {"notes", std::move(notes)}};
}

void Print(const VerifyReport& report) {
  Say("looked at: {} ({}), {}, {} ({} sealed), {} with {}, {}\n", Counted(report.blobs, "blob"),
      Mib(report.blob_bytes), Counted(report.people, "person", "people"),
      Counted(report.attempts, "attempt"), report.sealed, Counted(report.chunks, "chunk"),
      Counted(report.ticks, "tick"), Counted(report.keys, "key"));
  Say("checked: {}, {} of the audit trail, {} compared with it\n",
      Counted(report.results, "signed result"), Counted(report.audit_rows, "row"),
      Counted(report.decisions, "decision"));
  for (const AuditHead& head : report.trail) {
    Say("it ends with row {}, hash {}; verify --since BACKUP compares it with an earlier end\n",
        head.number, head.hash.Hex());
  }
  if (report.unnamed_blobs > 0) {
    Say("{} unused ({}), left by a crash or a repeated scoring; retention --apply removes those "
        "older than a day\n",
        Counted(report.unnamed_blobs, "blob is", "blobs are"), Mib(report.unnamed_bytes));
  }
  for (const std::string& note : report.notes) Say("note: {}\n", note);
  for (size_t i = 0; i < report.findings.size() && i < kShownFindings; ++i) {
    const Finding& finding = report.findings[i];
    Say("{} {}\n  expected: {}\n  found:    {}\n  do:       {}\n", finding.kind, finding.object,
        finding.expected, finding.found, finding.remedy);
  }
  if (report.findings.size() > kShownFindings) {
    Say("and {} more (--json FILE has them all)\n", report.findings.size() - kShownFindings);
  }
}

Status Verdict(const VerifyReport& report) {
  if (report.findings.empty()) {
    Say("everything agrees\n");
    return Status::Ok();
  }
  return Status(Code::kStorage,
                Counted(report.findings.size(), "thing does not agree", "things do not agree") +
                    "; see the list");
}

}  // namespace

namespace {

json::object Outcome(const BackupReport& report) {
  return {{"files", report.files}, {"bytes", report.bytes}, {"missing", report.missing.size()}};
}

// If the server has ended, the pipe is broken and this process ends with the next line.
void PrintLine(const json::object& line) { std::cout << json::serialize(line) << std::endl; }

// What is copied, in the few words that the page knows.
const char* PhaseOf(const std::string& what) {
  if (what == "blobs") return "blobs";
  return what == "keys" ? "keys" : "database";
}

// This process ends with the server that started it, and makes room for it.
void BeChildOfServer(int nice) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  (void)::setpriority(PRIO_PROCESS, 0, nice);
}

// Prints a line when the phase changes, and now and then.
UpkeepProgress PrintingLines() {
  static constexpr std::chrono::milliseconds kEvery{200};
  return [phase = std::string(), next = std::chrono::steady_clock::time_point()](
             const std::string& what, uint64_t done, uint64_t all) mutable {
    const auto now = std::chrono::steady_clock::now();
    if (phase == PhaseOf(what) && now < next) return;
    phase = PhaseOf(what);
    next = now + kEvery;
    PrintLine({{"phase", phase}, {"done", done}, {"all", all}});
  };
}

Status BackupForServer(const BackupCommand& command) {
  BeChildOfServer(10);  // as enamel-backup.service
  const auto report = BackUp({command.data, command.target, command.keyring, command.copy,
                              SoftwareName(), PrintingLines()});
  PrintLine(report.ok() ? Outcome(*report)
                        : json::object{{"problem", AsUtf8(report.status().message())}});
  return report.status();
}

}  // namespace

Status Backup(const BackupCommand& command) {
  if (command.report) return BackupForServer(command);
  // Opening brings an older database up to date first, and tells when there is none at all.
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(command.data));
  // The progress line is wiped when its object goes, so it goes before anything is said.
  Result<BackupReport> report = [&] {
    ConsoleProgress progress;
    return BackUp({command.data, command.target, command.keyring, command.copy, SoftwareName(),
                   Telling(progress)});
  }();
  const std::string place = std::filesystem::absolute(command.target).string();
  if (!report.ok()) {
    // The page shows it: of a nightly backup nobody else might hear.
    (void)store->audit.NoteAudit(
        kCommandLine, kBackupFailed, place,
        json::serialize(json::object{{"problem", AsUtf8(report.status().message())}}));
    return report.status();
  }
  ENAMEL_RETURN_IF_ERROR(
      store->audit.NoteAudit(kCommandLine, kBackupMade, place, json::serialize(Outcome(*report))));
  Say("backup as of {}: {}, {} ({} linked), {}, {}, {}\n", UtcText(report->created_ms) + " UTC",
      Counted(report->files, "file"), Mib(report->bytes), report->linked,
      Counted(report->people, "person", "people"), Counted(report->attempts, "attempt"),
      Counted(report->ticks, "tick"));
  if (command.keyring.empty()) {
    Say("the keys are inside; with --keyring FOLDER they are kept apart, so that an erasure "
        "reaches old backups too\n");
  } else {
    Say("the keys are in {}: without them no recording of this backup can be read\n",
        command.keyring.string());
  }
  // Not a failure of the backup: it has everything undamaged, and an older backup may have the
  // rest. The exit code shows that somebody has to look.
  json::array missing;
  for (const Sha256& hash : report->missing) missing.emplace_back(hash.Hex());
  size_t lost = missing.size();
  for (const Sha256& hash : report->missing) Say("missing or damaged: blob {}\n", hash.Hex());
  ENAMEL_RETURN_IF_ERROR(program::WriteJsonFile(command.json, {{"created_ms", report->created_ms},
                                                               {"files", report->files},
                                                               {"bytes", report->bytes},
                                                               {"linked", report->linked},
                                                               {"people", report->people},
                                                               {"attempts", report->attempts},
                                                               {"ticks", report->ticks},
                                                               {"missing", std::move(missing)}}));
  if (lost == 0) return Status::Ok();
  return Status(
      Code::kStorage,
      Counted(lost, "blob that the database names is", "blobs that the database names are") +
          " missing or damaged; everything else is in the backup. Keep older backups, they "
          "may have what is missing");
}

Status BackUpSchools(const BackupCommand& command) {
  std::error_code error;
  // Not made: where a disk is not mounted, the backups would fill the one below.
  if (!std::filesystem::is_directory(command.into, error)) {
    return Status(Code::kNotFound,
                  "expected a folder for backups at " + command.into.string() +
                      ", found none; mount its disk, or make the folder",
                  "into");
  }
  const std::string name = BackupName();
  BackupCommand own = command;
  ENAMEL_ASSIGN_OR_RETURN(own.target, NewBackupIn(command.into, name));
  Status all = Backup(own);
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(command.data));
  ENAMEL_ASSIGN_OR_RETURN(const auto schools, store->schools.Schools());
  for (const SchoolRow& row : schools) {
    if (row.state != SchoolState::kServed && row.state != SchoolState::kSuspended) continue;
    BackupCommand other = command;
    other.data = SchoolFolder(command.data, row.name);
    if (!command.keyring.empty()) other.keyring = SchoolFolder(command.keyring, row.name);
    Status made = EnsureSchoolFolder(command.data, row, SchoolData::kExpect).status();
    if (made.ok()) {
      auto target = NewBackupIn(SchoolFolder(command.into, row.name), name);
      made = target.status();
      if (target.ok()) other.target = *target;
    }
    if (made.ok()) made = Backup(other);
    if (made.ok()) continue;
    Say("school {}: {}\n", row.name, made.message());
    if (all.ok()) all = Status(made.code(), "school " + row.name + ": " + made.message());
  }
  return all;
}

namespace {

// A backup of an installation has the list of its other schools, and none of their data.
Status SuspendListedSchools(const std::filesystem::path& data) {
  ENAMEL_ASSIGN_OR_RETURN(const auto store, OpenForCommand(data));
  ENAMEL_ASSIGN_OR_RETURN(const auto schools, store->schools.Schools());
  for (SchoolRow row : schools) {
    if (row.state == SchoolState::kServed) {
      row.state = SchoolState::kSuspended;
      ENAMEL_RETURN_IF_ERROR(store->schools.ChangeSchool(row, kCommandLine));
    }
    Say("school {} is listed and suspended: each school has backups of its own; restore it into "
        "{}, "
        "then school resume {}\n",
        row.name, SchoolFolder(data, row.name).string(), row.name);
  }
  return Status::Ok();
}

}  // namespace

namespace {

RestoreOptions OptionsOf(const RestoreCommand& command, UpkeepProgress progress) {
  RestoreOptions options;
  options.backup = command.backup;
  options.data = command.data;
  options.keyrings = command.keyrings;
  options.accept_damage = command.accept_damage;
  options.progress = std::move(progress);
  return options;
}

Status DrillForServer(const RestoreCommand& command) {
  constexpr int kIdleClass = 3 << 13, kThisProcess = 1;  // linux/ioprio.h
  BeChildOfServer(19);
  (void)::syscall(SYS_ioprio_set, kThisProcess, 0, kIdleClass);
  const auto report = Restore(OptionsOf(command, PrintingLines()));
  if (!report.ok()) {
    PrintLine({{"problem", AsUtf8(report.status().message())}});
    return report.status();
  }
  json::object outcome{{"files", report->files},
                       {"bytes", report->bytes},
                       {"findings", report->verified.findings.size()}};
  if (!report->verified.findings.empty()) {
    const Finding& first = report->verified.findings.front();
    outcome["first"] = AsUtf8(first.kind + " " + first.object + ": expected " + first.expected +
                              ", found " + first.found);
  }
  PrintLine(outcome);
  return Status::Ok();
}

// Replaces an empty `folder` with the newest backup in `newest`.
Status TakeNewest(const std::filesystem::path& newest, std::filesystem::path& folder) {
  if (newest.empty()) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(folder, NewestBackup(newest));
  Say("the newest backup: {}\n", folder.string());
  return Status::Ok();
}

}  // namespace

Status RestoreBackup(const RestoreCommand& asked) {
  RestoreCommand command = asked;
  if (command.report) return DrillForServer(command);
  ENAMEL_RETURN_IF_ERROR(TakeNewest(command.newest, command.backup));
  Result<RestoreReport> report = [&] {
    ConsoleProgress progress;
    return Restore(OptionsOf(command, Telling(progress)));
  }();
  ENAMEL_RETURN_IF_ERROR(report.status());
  Say("restored the backup of {}: {}, {}\n", UtcText(report->created_ms) + " UTC",
      Counted(report->files, "file"), Mib(report->bytes));
  Say("{} erased again; all sessions have ended\n",
      Counted(report->erased_again, "person erased since was", "people erased since were"));
  Say("changes made after the backup are lost: disable people and revoke stations again where that "
      "was done since. Stations send what they still hold; where that needs something newer than "
      "the backup, admin list-awaited shows what. A station that is newer comes back with "
      "enamel-station enrol --again\n");
  if (command.keyrings.empty()) {
    Say("erasures made after the backup are unknown here; to apply them, name the newest key ring "
        "with --keyring\n");
  }
  ENAMEL_RETURN_IF_ERROR(SuspendListedSchools(command.data));
  json::array left_out;
  for (const std::string& file : report->left_out) {
    Say("left out: {}\n", file);
    left_out.emplace_back(file);
  }
  Print(report->verified);
  ENAMEL_RETURN_IF_ERROR(
      program::WriteJsonFile(command.json, {{"created_ms", report->created_ms},
                                            {"files", report->files},
                                            {"bytes", report->bytes},
                                            {"erased_again", report->erased_again},
                                            {"left_out", std::move(left_out)},
                                            {"verified", JsonOf(report->verified)}}));
  return Verdict(report->verified);
}

Status VerifyFolder(const VerifyCommand& asked) {
  VerifyCommand command = asked;
  ENAMEL_RETURN_IF_ERROR(TakeNewest(command.newest, command.folder));
  Result<VerifyReport> report = [&] {
    ConsoleProgress progress;
    return Verify({command.folder, command.keyring, Telling(progress), command.since,
                   command.is_backup || !command.newest.empty()});
  }();
  ENAMEL_RETURN_IF_ERROR(report.status());
  Print(*report);
  // Before the verdict: the file is wanted most when something disagrees.
  ENAMEL_RETURN_IF_ERROR(program::WriteJsonFile(command.json, JsonOf(*report)));
  return Verdict(*report);
}

Status Retention(const RetentionCommand& command) {
  // One without the other.
  if (command.what.empty() == command.days.has_value()) {
    return Status(
        Code::kInvalidInput,
        "--set and --days go together, such as --set recordings --days 730; --days 0 takes "
        "the rule away",
        "days");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto store, OpenForCommand(command.data));
  if (!command.what.empty()) {
    ENAMEL_RETURN_IF_ERROR(
        store->retention.SetRetention({command.what, *command.days}, kCommandLine));
  }
  ENAMEL_ASSIGN_OR_RETURN(auto rules, store->retention.RetentionRules());
  if (rules.empty()) Say("no rules: everything is kept indefinitely\n");
  for (const RetentionRule& rule : rules) {
    Say("{:<10} kept for {}\n", rule.what, Counted(rule.days, "day"));
  }
  // With the new rule in force: without --apply this shows what the server will remove at its next
  // round.
  ENAMEL_ASSIGN_OR_RETURN(
      auto report, store->retention.ApplyRetention(enamel::UnixMs(), !command.apply, kCommandLine));
  Say("{}: {}, {}, {}{}\n", command.apply ? "removed" : "would be removed now",
      Counted(report.unfinished.size(), "unfinished attempt"),
      Counted(report.recordings.size(), "recording"),
      Counted(report.attempts.size(), "whole attempt"),
      command.apply ? ", " + Counted(report.blobs, "blob") : "");
  if (report.held > 0) {
    Say("{} due and kept: an appeal waits for its answer, or graded work to be released or "
        "excused\n",
        Counted(report.held, "more is", "more are"));
  }
  return Status::Ok();
}

namespace {

constexpr char kNewestHelp[] =
    "Instead of BACKUP: the newest finished one in this folder, by its audit trail and not by its "
    "name";

}  // namespace

void DeclareBackup(CommandGroup root) {
  auto [backup, b] = Declare<BackupCommand>(
      root, "backup", "Copy the data folder; the server may be running",
      [](const BackupCommand& command) {
        if (!command.into.empty()) return BackUpSchools(command);
        if (!command.target.empty()) return Backup(command);
        return Status(Code::kInvalidInput, "expected TARGET or --into FOLDER, found neither");
      });
  auto* target = backup->add_option("TARGET", b.target, "Folder to make; absent or empty");
  auto* json = backup->add_option("--json", b.json, "Write the outcome to this file");
  backup
      ->add_option("--into", b.into,
                   "Instead of TARGET: make a folder in this one, named by the time, and one in "
                   "schools/NAME of it for each other school of the installation")
      ->excludes(target)
      ->excludes(json);
  AddData(backup, b.data);
  backup->add_option(
      "--keyring", b.keyring,
      "Keep keys and erasures in this folder instead of inside the backup. Use the same folder "
      "every time, and do not copy it: erasures would not reach the copy");
  backup->add_flag("--copy", b.copy, "Copy every file, even where a hard link would do");
  backup->add_flag("--report", b.report)->group("");
  backup->footer(
      "A backup is consistent as of one moment and has a manifest with the hash of every file.\n"
      "Hard links save space but are lost with the disk: back up to another disk.\n"
      "It is written to TARGET.part, and gets its name when it is whole.");
  AddExample(backup, "/var/backups/enamel/before-update");

  auto [restore, r] = Declare<RestoreCommand>(
      root, "restore", "Make a data folder from a backup, and verify it",
      [](const RestoreCommand& command) {
        if (!command.backup.empty() || !command.newest.empty()) return RestoreBackup(command);
        return Status(Code::kInvalidInput, "expected BACKUP or --newest FOLDER, found neither");
      });
  auto* from = restore->add_option("BACKUP", r.backup, "What `backup` made");
  restore->add_option("--newest", r.newest, kNewestHelp)->excludes(from);
  restore->add_flag("--report", r.report)->group("");
  AddData(restore, r.data)->description("Folder to make; absent or empty");
  restore->add_option(
      "--keyring", r.keyrings,
      "Newer key ring (repeatable): the keyring folder of the lost data folder, or the one that "
      "backup --keyring wrote. People erased there are erased here too");
  restore->add_flag("--accept-damage", r.accept_damage,
                    "Leave out files that are missing or damaged, and list them");
  restore->add_option("--json", r.json, "Write the outcome to this file");
  program::AddExamples(*restore, {"--newest /var/backups/enamel --data /var/lib/enamel-new"});

  struct Asked {
    VerifyCommand verify;
    std::filesystem::path data;
  };
  auto [verify, v] =
      Declare<Asked>(root, "verify", "Check every hash, chain, signature, seal and key",
                     [](Asked& asked) -> Status {
                       asked.verify.is_backup = !asked.verify.folder.empty();
                       if (!asked.verify.is_backup && asked.verify.newest.empty()) {
                         asked.verify.folder = asked.data;
                         if (asked.data.empty()) {
                           return Status(Code::kInvalidInput,
                                         "verify needs a backup, --newest FOLDER, or a data folder "
                                         "with --data DIR");
                         }
                       }
                       return VerifyFolder(asked.verify);
                     });
  auto* backed_up =
      verify->add_option("BACKUP", v.verify.folder, "A backup; without: the data folder");
  verify->add_option("--newest", v.verify.newest, kNewestHelp)->excludes(backed_up);
  AddData(verify, v.data)->required(false)->description("Data folder, in use or not");
  verify->add_option("--keyring", v.verify.keyring, "Key ring of a backup that has none inside");
  verify->add_option("--since", v.verify.since,
                     "An earlier backup that the audit trail must continue");
  verify->add_option("--json", v.verify.json, "Write everything that was found to this file");
  verify->footer(
      "Changes nothing. Exit code 1 when anything disagrees; all of it is listed first.");
  program::AddExamples(*verify, {"--newest /var/backups/enamel", "--data /var/lib/enamel"});
}

void DeclareRetention(CommandGroup root) {
  auto [cmd, o] = Declare<RetentionCommand>(root, "retention",
                                            "Show or set how long things are kept", app::Retention);
  AddData(cmd, o.data);
  cmd->add_option("--set", o.what, "unfinished, recordings or attempts")
      ->check(CLI::IsMember({"unfinished", "recordings", "attempts"}));
  cmd->add_option("--days", o.days, "Days for --set; 0 takes the rule away")
      ->check(CLI::Range(0, 36'500));
  cmd->add_flag("--apply", o.apply, "Now; a running server does it every hour");
  cmd->footer(
      "Shows the rules and what they would remove now.\n"
      "  unfinished   attempts that were never ended, from their beginning (at least 14 days)\n"
      "  recordings   motion, forces and the cut tooth, from the end; the score stays\n"
      "  attempts     all of an attempt, from the end\n"
      "Reference cuts are always kept.");
  AddExample(cmd, "--set recordings --days 730");
}

}  // namespace enamel::server::app
