#include <sodium.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <functional>
#include <iostream>

#include "common/base/utf8.h"
#include "common/program/log.h"
#include "common/program/settings.h"
#include "server/app/admin.h"
#include "server/app/admin_people.h"
#include "server/app/admin_stations.h"
#include "server/app/data_folder.h"
#include "server/app/personal_data.h"
#include "server/app/report.h"
#include "server/app/seed.h"
#include "server/app/serve.h"
#include "server/app/teaching.h"
#include "server/app/upkeep.h"

// enamel-server: command line only. Exit codes: 0 done, 1 refused or failed, 2 wrong usage.
namespace {

using namespace enamel;
using namespace enamel::server;

using Command = std::function<Status()>;

// Options live as long as the parser, so they are kept here.
struct Options {
  std::filesystem::path data, config, target;
  bool print_settings = false, with_references = false;
  program::LogOptions log;
  app::BackupCommand backup;
  app::RestoreCommand restore;
  app::VerifyCommand verify;
  app::RetentionCommand retention;
  std::string confirm;
  app::ServeOptions serve;
  app::SeedOptions seed;
  app::ReportOptions report;
  app::NewPerson person;
  app::RosterCommand roster;
  app::PeopleList people;
  std::string station, profile;
  std::filesystem::path file;
  bool check_only = false;
  app::NewExercise exercise;
  app::NewAssignment assignment;
  std::string exercise_name, exercise_state, assignment_id;
  std::string login, cohort, attempt, dentist;
  bool consent = false;
  bool password_from_stdin = false;
  int valid_minutes = 60;
  uint32_t limit = 50;
};

// --data, as every command but `serve` takes it. The environment is read here and not by the
// parser, which would let it overrule another command's option that has the same place.
CLI::Option* AddData(CLI::App* cmd, std::filesystem::path& data) {
  auto* option = cmd->add_option("--data", data, "Data folder of the server (or ENAMEL_DATA)");
  const char* given = std::getenv("ENAMEL_DATA");
  if (given != nullptr) data = given;
  return option->required(given == nullptr);
}

void AddAddresses(CLI::App* cmd, app::ServeOptions& serve) {
  cmd->add_option("--http", serve.http, "Page and API: address:port")->capture_default_str();
  cmd->add_option("--stations", serve.stations, "Station link: address:port")
      ->capture_default_str();
  cmd->add_option("--web", serve.web, "Folder of the built page (web/dist)");
  cmd->add_option("--http-cert", serve.http_certificate,
                  "Certificate chain of the page, PEM. Beyond loopback the page needs this,\n"
                  "--http-self-signed or --http-behind-proxy");
  cmd->add_option("--http-key", serve.http_key, "Its key, PEM");
  cmd->add_flag("--http-self-signed", serve.http_self_signed,
                "Make a certificate for the first --host-name, to start with");
  cmd->add_option("--http-behind-proxy", serve.http_proxies,
                  "Numeric address of the proxy that speaks TLS to the browsers and sets\n"
                  "X-Forwarded-For and X-Forwarded-Proto; nobody else is answered (repeatable)");
  cmd->add_option("--host-name", serve.host_names, "Name the page is reached under (repeatable)");
  cmd->add_option("--page-url", serve.page_url,
                  "Where people open the page: stations say it to whom they send there. Without:\n"
                  "made of the first --host-name");
}

void AddOperations(CLI::App* cmd, Options& o) {
  cmd->add_option("--job-threads", o.serve.job_threads, "Attempts scored at once; 0: scoring waits")
      ->check(CLI::Range(0, 64))
      ->capture_default_str();
  cmd->add_option(
         "--min-free-mib", o.serve.min_free_mib,
         "Recordings are refused, and wait at the stations, when the disk has less; 0: never")
      ->check(CLI::Range(0, 1 << 20))
      ->capture_default_str();
  cmd->add_option("--metrics-token-file", o.serve.metrics_token_file,
                  "File with the token that GET /metrics asks for; without: only this machine may")
      ->check(CLI::ExistingFile);
  cmd->add_option("--log-format", o.log.format, "text, or json: one object a line")
      ->capture_default_str();
  cmd->add_option("--log-level", o.log.level, "trace, debug, info, warning or error")
      ->capture_default_str();
}

// After the command line: the environment, the file, and what is needed from either.
Status FinishServe(CLI::App& cmd, Options& o) {
  ENAMEL_RETURN_IF_ERROR(program::ReadEnvironment(cmd));
  if (!o.config.empty()) ENAMEL_RETURN_IF_ERROR(program::ReadSettingsFile(o.config, cmd));
  if (o.serve.data.empty()) {
    return Status(Code::kInvalidInput,
                  "serve needs a data folder: --data DIR, ENAMEL_DATA, or data = \"DIR\" in the "
                  "settings file");
  }
  if (o.serve.http_certificate.empty() != o.serve.http_key.empty()) {
    return Status(Code::kInvalidInput, "--http-cert and --http-key go together; give both or none");
  }
  if (o.serve.http_self_signed && !o.serve.http_key.empty()) {
    return Status(Code::kInvalidInput,
                  "--http-self-signed makes the certificate that --http-cert gives; choose one");
  }
  return program::SetUpLog(o.log);
}

void AddServe(CLI::App& root, Options& o, Command& command) {
  auto* cmd = root.add_subcommand("serve", "Run the server until Ctrl-C");
  cmd->add_option("--data", o.serve.data, "Data folder; made when absent");
  AddAddresses(cmd, o.serve);
  AddOperations(cmd, o);
  cmd->add_option("--config", o.config, "TOML file with any of these settings")
      ->check(CLI::ExistingFile);
  cmd->add_flag("--print-settings", o.print_settings,
                "Show what is set, from wherever, as such a file; and end");
  cmd->footer(
      "Every setting can come from the command line, from the environment (--job-threads is\n"
      "ENAMEL_JOB_THREADS) or from the file; the nearer one wins, in this order.\n\n"
      "  enamel-server serve --data /srv/enamel                   try it, on this machine only\n"
      "  enamel-server serve --config /etc/enamel/server.toml     as a service (server/ops)\n\n"
      "Watch it with GET /healthz (503 when no recordings are taken) and GET /metrics "
      "(Prometheus).");
  cmd->callback([&, cmd] {
    command = [&, cmd]() -> Status {
      ENAMEL_RETURN_IF_ERROR(FinishServe(*cmd, o));
      if (o.print_settings) {
        std::cout << program::SettingsText(*cmd);
        return Status::Ok();
      }
      return app::Serve(o.serve);
    };
  });
}

void AddBackup(CLI::App& root, Options& o, Command& command) {
  auto* backup = root.add_subcommand("backup", "Copy the data folder, also while the server runs");
  backup->add_option("TARGET", o.backup.target, "Folder to make; absent or empty")->required();
  AddData(backup, o.backup.data);
  backup->add_option("--keyring", o.backup.keyring,
                     "Keep keys and erasures in this folder instead of inside; use the same one "
                     "every time, and no other medium than the backups' own");
  backup->add_flag("--copy", o.backup.copy,
                   "Copy every file, where links to the same disk would do");
  backup->add_option("--json", o.backup.json, "Write the outcome to this file");
  backup->footer(
      "A backup is consistent as of one moment and has a manifest with the hash of every file.\n"
      "Links save space and share the disk's fate: back up to another disk.\n\n"
      "  enamel-server backup /mnt/backup/2026-09-01 --data /srv/enamel\n"
      "  enamel-server verify /mnt/backup/2026-09-01\n"
      "  enamel-server restore /mnt/backup/2026-09-01 --data /srv/enamel-new");
  backup->callback([&] { command = [&] { return app::Backup(o.backup); }; });

  auto* restore = root.add_subcommand("restore", "Make a data folder from a backup, and verify it");
  restore->add_option("BACKUP", o.restore.backup, "What `backup` made")->required();
  AddData(restore, o.restore.data)->description("Folder to make; absent or empty");
  restore->add_option("--keyring", o.restore.keyrings,
                      "Newer key ring (repeatable): the keyring folder of the lost data folder, or "
                      "what backup --keyring kept. People erased there are erased here too");
  restore->add_flag("--accept-damage", o.restore.accept_damage,
                    "Leave out files that are missing or damaged, and say which");
  restore->add_option("--json", o.restore.json, "Write the outcome to this file");
  restore->callback([&] { command = [&] { return app::RestoreBackup(o.restore); }; });

  auto* verify = root.add_subcommand(
      "verify", "Compare everything with everything: hashes, chains, signatures, seals, keys");
  verify->add_option("BACKUP", o.verify.folder, "A backup; without: the data folder");
  AddData(verify, o.data)->required(false)->description("Data folder, in use or not");
  verify->add_option("--keyring", o.verify.keyring, "Key ring of a backup that has none inside");
  verify->add_option("--json", o.verify.json, "Write everything that was found to this file");
  verify->footer("Changes nothing. Exit code 1 when anything disagrees, after all of it was told.");
  verify->callback([&] {
    command = [&]() -> Status {
      if (o.verify.folder.empty()) o.verify.folder = o.data;
      if (!o.verify.folder.empty()) return app::VerifyFolder(o.verify);
      return Status(Code::kInvalidInput, "verify needs a backup, or a data folder with --data DIR");
    };
  });
}

void AddRetention(CLI::App& root, Options& o, Command& command) {
  auto* cmd = root.add_subcommand("retention", "How long things are kept");
  AddData(cmd, o.retention.data);
  cmd->add_option("--set", o.retention.what, "unfinished, recordings or attempts")
      ->check(CLI::IsMember({"unfinished", "recordings", "attempts"}));
  cmd->add_option("--days", o.retention.days, "Days for --set; 0 takes the rule away")
      ->check(CLI::Range(0, 36'500));
  cmd->add_flag("--apply", o.retention.apply, "Now; a running server does it every hour");
  cmd->footer(
      "Shows the rules and what they would remove now.\n"
      "  unfinished   attempts that were never ended, from their beginning (at least 14 days)\n"
      "  recordings   motion, forces and the cut tooth, from the end; the score stays\n"
      "  attempts     all of an attempt, from the end\n"
      "Reference cuts are kept whatever the rules say.\n\n"
      "  enamel-server retention --data /srv/enamel --set recordings --days 730");
  cmd->callback([&] { command = [&] { return app::Retention(o.retention); }; });
}

void AddSeed(CLI::App& root, Options& o, Command& command) {
  auto* cmd =
      root.add_subcommand("seed-demo", "Demo people, profiles, molar and exercise; idempotent");
  AddData(cmd, o.data);
  cmd->add_option("--scene", o.seed.scene, "Folder of an imported scene to offer as well");
  cmd->add_option("--voxel-um", o.seed.voxel_um, "Voxel size of the built-in molar")
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  cmd->add_option("--json", o.seed.json, "Write the facts to this file");
  cmd->callback([&] {
    command = [&] {
      o.seed.data = o.data;
      return app::SeedDemo(o.seed);
    };
  });
}

void AddReport(CLI::App& root, Options& o, Command& command) {
  auto* cmd = root.add_subcommand("report", "Score, reasons and trace statistics of an attempt");
  AddData(cmd, o.data);
  cmd->add_option("--attempt", o.report.attempt)->required();
  cmd->add_option("--json", o.report.json, "Write the same facts to this file");
  cmd->add_option("--wait", o.report.wait_s, "Seconds to wait for the score")
      ->check(CLI::Range(0, 86400));
  cmd->add_option("--page-url", o.report.page_url, "Address of the attempt's page, to be printed");
  cmd->callback([&] {
    command = [&] {
      o.report.data = o.data;
      return app::Report(o.report);
    };
  });
}

void AddPeople(CLI::App& admin, Options& o, Command& command) {
  auto* add = admin.add_subcommand("add-person", "Add a person");
  AddData(add, o.data);
  add->add_option("--login", o.person.login)->required();
  add->add_option("--name", o.person.display_name, "Name as shown");
  add->add_option("--role", o.person.role, "student, instructor or admin")->required();
  add->add_option("--id", o.person.id,
                  "Of a person that a restore has forgotten: what list-awaited shows");
  add->add_flag("--password-stdin", o.person.password_from_stdin,
                "Read the password; else one is made up");
  add->callback([&] { command = [&] { return app::AddPerson(o.data, o.person); }; });

  auto* password =
      admin.add_subcommand("set-password", "Set a password; ends the person's sessions");
  AddData(password, o.data);
  password->add_option("--login", o.login)->required();
  password->add_flag("--password-stdin", o.password_from_stdin,
                     "Read the password; else one is made up");
  password->callback(
      [&] { command = [&] { return app::SetPassword(o.data, o.login, o.password_from_stdin); }; });

  for (bool disabled : {true, false}) {
    auto* cmd =
        admin.add_subcommand(disabled ? "disable" : "enable", "Let a person sign in or not");
    AddData(cmd, o.data);
    cmd->add_option("--login", o.login)->required();
    cmd->callback([&o, &command, disabled] {
      command = [&o, disabled] { return app::SetDisabled(o.data, o.login, disabled); };
    });
  }

  auto* cohort = admin.add_subcommand("add-cohort", "Add a cohort");
  AddData(cohort, o.data);
  cohort->add_option("--name", o.cohort)->required();
  cohort->callback([&] { command = [&] { return app::AddCohort(o.data, o.cohort); }; });

  auto* member = admin.add_subcommand("add-to-cohort", "Add a student or instructor to a cohort");
  AddData(member, o.data);
  member->add_option("--cohort", o.cohort)->required();
  member->add_option("--login", o.login)->required();
  member->callback([&] { command = [&] { return app::AddToCohort(o.data, o.cohort, o.login); }; });
}

void AddRoster(CLI::App& admin, Options& o, Command& command) {
  auto* roster = admin.add_subcommand("import-roster", "People and cohorts from a CSV file");
  roster->add_option("FILE", o.roster.file, "login,display_name,role,cohort (schemas/roster.md)")
      ->required()
      ->check(CLI::ExistingFile);
  AddData(roster, o.roster.data);
  roster->add_flag("--dry-run", o.roster.dry_run, "Tell what would happen; change nothing");
  roster->add_option("--cohort", o.roster.cohort, "Cohort of rows that name none");
  roster->add_option("--passwords", o.roster.passwords,
                     "File to make (mode 0600) with the one-time passwords of who is new");
  roster->add_flag("--ignore-unknown-columns", o.roster.ignore_unknown_columns,
                   "Leave out columns of other names instead of refusing them");
  roster->add_option("--json", o.roster.json, "Write the outcome to this file, without passwords");
  roster->footer(
      "All or nothing: with a problem in any row nothing is changed, and all problems are told.\n"
      "Who is there keeps role and password, takes the name and joins the cohort; nobody is\n"
      "removed. Importing the same file again changes nothing.\n\n"
      "  enamel-server admin import-roster year3.csv --data /srv/enamel --dry-run\n"
      "  enamel-server admin import-roster year3.csv --data /srv/enamel --passwords year3-new.csv");
  roster->callback([&] { command = [&] { return app::ImportRoster(o.roster); }; });

  auto* people = admin.add_subcommand("list-people", "People by login");
  AddData(people, o.people.data);
  people->add_option("--role", o.people.role, "Only students, instructors or admins");
  people->add_option("--cohort", o.people.cohort, "Only of this cohort");
  people->add_option("--text", o.people.text, "Only with this in login or name");
  people->add_option("--limit", o.people.limit)
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  people->callback([&] { command = [&] { return app::ListPeople(o.people); }; });

  auto* cohorts =
      admin.add_subcommand("list-cohorts", "Cohorts by name, with how many are in them");
  AddData(cohorts, o.data);
  cohorts->callback([&] { command = [&] { return app::ListCohorts(o.data); }; });
}

void AddSessions(CLI::App& admin, Options& o, Command& command) {
  auto* list = admin.add_subcommand("list-sessions", "Where a person is signed in");
  AddData(list, o.data);
  list->add_option("--login", o.login)->required();
  list->callback([&] { command = [&] { return app::ListSessions(o.data, o.login); }; });

  auto* end = admin.add_subcommand("end-sessions", "Sign a person out everywhere");
  AddData(end, o.data);
  end->add_option("--login", o.login)->required();
  end->callback([&] { command = [&] { return app::EndSessions(o.data, o.login); }; });
}

void AddStations(CLI::App& admin, Options& o, Command& command) {
  auto* list = admin.add_subcommand("list-stations", "Stations by name: admitted, seen, software");
  AddData(list, o.data);
  list->callback([&] { command = [&] { return app::ListStations(o.data); }; });

  auto* awaited = admin.add_subcommand(
      "list-awaited", "Recordings that wait at stations for what a restore has forgotten");
  AddData(awaited, o.data);
  awaited->callback([&] { command = [&] { return app::ListAwaited(o.data); }; });

  auto* revoke = admin.add_subcommand("revoke-station", "Stop admitting a station, for good");
  AddData(revoke, o.data);
  revoke->add_option("--station", o.station, "Its name, or the id list-stations shows")->required();
  revoke->callback([&] { command = [&] { return app::RevokeStation(o.data, o.station); }; });
}

void AddProfiles(CLI::App& admin, Options& o, Command& command) {
  auto* put = admin.add_subcommand("put-profile", "Check a device profile and store it");
  put->add_option("FILE", o.file, "schemas/device_profile.schema.json")
      ->required()
      ->check(CLI::ExistingFile);
  AddData(put, o.data);
  put->add_flag("--check", o.check_only, "Only show the criteria with their figures");
  put->callback([&] { command = [&] { return app::PutProfile(o.data, o.file, o.check_only); }; });

  auto* report = admin.add_subcommand("add-report", "Attach a qualification report to a profile");
  report->add_option("FILE", o.file, "What `enamel-lab qualify --report` wrote")
      ->required()
      ->check(CLI::ExistingFile);
  AddData(report, o.data);
  report->add_option("--profile", o.profile, "Name of the profile")->required();
  report->callback(
      [&] { command = [&] { return app::AddProfileReport(o.data, o.profile, o.file); }; });

  auto* add = admin.add_subcommand("add-calibration", "Keep what a device was measured to be");
  add->add_option("FILE", o.file, "What `enamel-station calibrate` wrote")
      ->required()
      ->check(CLI::ExistingFile);
  AddData(add, o.data);
  add->callback([&] { command = [&] { return app::AddCalibration(o.data, o.file); }; });

  auto* list =
      admin.add_subcommand("list-calibrations", "Devices of a profile as they were measured");
  AddData(list, o.data);
  list->add_option("--profile", o.profile, "Name of the profile")->required();
  list->callback([&] { command = [&] { return app::ListCalibrations(o.data, o.profile); }; });
}

void AddPersonalData(CLI::App& admin, Options& o, Command& command) {
  auto* copy = admin.add_subcommand("export-person", "Write all that is kept about a person");
  AddData(copy, o.data);
  copy->add_option("--login", o.login)->required();
  copy->add_option("TARGET", o.target, "Folder to make; absent or empty")->required();
  copy->callback([&] { command = [&] { return app::ExportPerson(o.data, o.login, o.target); }; });

  auto* erase =
      admin.add_subcommand("erase-person", "Erase everything that is kept about a person");
  AddData(erase, o.data);
  erase->add_option("--login", o.login)->required();
  erase->add_option("--confirm", o.confirm, "The login once more: this cannot be undone")
      ->required();
  erase->add_flag("--with-references", o.with_references,
                  "Also when attempts of this person are reference cuts");
  erase->callback([&] {
    command = [&] { return app::ErasePerson(o.data, o.login, o.confirm, o.with_references); };
  });
}

void AddContent(CLI::App& admin, Options& o, Command& command) {
  auto* code = admin.add_subcommand("enrol-code", "One-time code for a station: CODE@FINGERPRINT");
  AddData(code, o.data);
  code->add_option("--minutes", o.valid_minutes, "How long it can be used")
      ->check(CLI::Range(1, 7 * 24 * 60))
      ->capture_default_str();
  code->callback([&] { command = [&] { return app::EnrolCode(o.data, o.valid_minutes); }; });

  auto* mark =
      admin.add_subcommand("mark-reference", "Make a scored attempt its exercise's reference");
  AddData(mark, o.data);
  mark->add_option("--attempt", o.attempt)->required();
  mark->add_option("--dentist", o.dentist, "Name to be shown to students")->required();
  mark->add_flag("--consent", o.consent,
                 "The dentist agrees to being named and to the cut being used; needed");
  mark->callback([&] {
    command = [&] { return app::MarkReference(o.data, o.attempt, o.dentist, o.consent); };
  });

  auto* release = admin.add_subcommand("release", "Let the student see a graded score");
  AddData(release, o.data);
  auto* one = release->add_option("--attempt", o.attempt, "One attempt's");
  release->add_option("--assignment", o.assignment_id, "Of every scored attempt under it")
      ->excludes(one);
  release->callback([&] {
    command = [&]() -> Status {
      if (!o.assignment_id.empty()) return app::ReleaseAssignment(o.data, o.assignment_id);
      if (!o.attempt.empty()) return app::ReleaseScore(o.data, o.attempt);
      return Status(Code::kInvalidInput, "release needs --attempt ID or --assignment ID");
    };
  });

  auto* list = admin.add_subcommand("list-attempts", "Newest attempts first");
  AddData(list, o.data);
  list->add_option("--limit", o.limit)->check(CLI::Range(1, 1'000'000))->capture_default_str();
  list->callback([&] { command = [&] { return app::ListAttempts(o.data, o.limit); }; });
}

void AddExercises(CLI::App& admin, Options& o, Command& command) {
  auto* publish = admin.add_subcommand("publish-exercise", "Offer exercises on a scene");
  AddData(publish, o.data);
  publish->add_option("--scene", o.exercise.scene, "Scene folder, or builtin:molar and the like");
  publish->add_option("--name", o.exercise.name,
                      "Only this one, or this kind: class-1, class-2, crown, cross");
  publish->add_option("--document", o.exercise.document,
                      "Instead: file with an exercise (schemas/exercise.schema.json)");
  auto* cohort = publish->add_option("--cohort", o.exercise.cohort, "For whom; without: everybody");
  publish
      ->add_flag("--unassigned", o.exercise.unassigned,
                 "For nobody yet: assign-exercise says for whom and when")
      ->excludes(cohort);
  publish->add_option("--voxel-um", o.exercise.voxel_um, "Voxel size of a built-in scene")
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  publish->footer(
      "A document that differs from the newest version of its name becomes the next version;\n"
      "a published version never changes. Dates, limits and exams: assign-exercise.\n\n"
      "  enamel-server admin publish-exercise --data DIR --scene builtin:molar --name class-1");
  publish->callback([&] { command = [&] { return app::PublishExercise(o.data, o.exercise); }; });

  auto* retire =
      admin.add_subcommand("retire-exercise", "Stop offering it: no version can be assigned");
  AddData(retire, o.data);
  retire->add_option("--name", o.exercise_name)->required();
  retire->callback([&] { command = [&] { return app::RetireExercise(o.data, o.exercise_name); }; });

  auto* list = admin.add_subcommand("list-exercises", "Drafts, what is offered, what was retired");
  AddData(list, o.data);
  list->add_option("--state", o.exercise_state, "Only these")
      ->check(CLI::IsMember({"draft", "published", "retired"}));
  list->callback([&] { command = [&] { return app::ListExercises(o.data, o.exercise_state); }; });
}

void AddAssignments(CLI::App& admin, Options& o, Command& command) {
  auto* assign = admin.add_subcommand("assign-exercise", "Have a cohort do an exercise");
  AddData(assign, o.data);
  app::NewAssignment& row = o.assignment;
  assign->add_option("--exercise", row.exercise, "Its name; the newest version counts")->required();
  assign->add_option("--cohort", row.cohort, "For whom; without: everybody");
  assign->add_option("--opens", row.opens, "Not before: \"2026-11-20 09:00\", UTC");
  assign->add_option("--due", row.due, "Not after; an attempt begun before may end after, flagged");
  assign->add_option("--attempts", row.attempt_limit, "Attempts each; 0: no limit")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  assign->add_flag("--late", row.late_allowed, "Let attempts begin after it is due, flagged");
  assign->add_flag("--exam", row.exam,
                   "No score before it is released; begun online, one at a time");
  assign->add_option("--station", row.stations, "Where the exam is taken (repeatable)");
  assign->footer(
      "  enamel-server admin assign-exercise --data DIR --exercise class-1-molar-46 --cohort "
      "\"Year 2\" \\\n"
      "      --opens \"2026-12-01 08:00\" --due \"2026-12-01 12:00\" --attempts 1 --exam");
  assign->callback([&] { command = [&] { return app::AssignExercise(o.data, o.assignment); }; });

  auto* end = admin.add_subcommand(
      "end-assignment",
      "Take an assignment away; one with attempts is due now instead, and stays for their release");
  AddData(end, o.data);
  end->add_option("--assignment", o.assignment_id)->required();
  end->callback([&] { command = [&] { return app::EndAssignment(o.data, o.assignment_id); }; });

  auto* list = admin.add_subcommand("list-assignments", "Assignments, by due time");
  AddData(list, o.data);
  list->callback([&] { command = [&] { return app::ListAssignments(o.data); }; });
}

}  // namespace

int main(int argc, char** argv) {
  const bool json = program::AsksForJson(argc, argv, "ENAMEL_");
  (void)program::SetUpLog({.format = json ? "json" : "text"});
  if (sodium_init() < 0) {
    program::SayError("libsodium cannot be initialised on this machine");
    return 1;
  }
  Options options;
  Command command;
  CLI::App root("Enamel server: station link, storage, scoring, API and page");
  root.require_subcommand(1);
  root.set_version_flag("--version", std::string(app::kSoftware));
  AddServe(root, options, command);
  AddBackup(root, options, command);
  AddRetention(root, options, command);
  AddSeed(root, options, command);
  AddReport(root, options, command);
  auto* admin = root.add_subcommand("admin", "People, cohorts, stations, exercises, references");
  admin->require_subcommand(1);
  AddPeople(*admin, options, command);
  AddRoster(*admin, options, command);
  AddSessions(*admin, options, command);
  AddStations(*admin, options, command);
  AddProfiles(*admin, options, command);
  AddPersonalData(*admin, options, command);
  AddContent(*admin, options, command);
  AddExercises(*admin, options, command);
  AddAssignments(*admin, options, command);
  root.footer(
      "First steps:\n"
      "  enamel-server serve --data DIR                 in one terminal; then, in another:\n"
      "  enamel-server admin add-person --data DIR --login anna --role admin\n"
      "  enamel-server admin enrol-code --data DIR      for `enamel-station enrol`\n"
      "Each command has its own --help. Exit codes: 0 done, 1 refused or failed, 2 wrong usage.");
  try {
    root.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const bool wrong = error.get_exit_code() != 0;
    if (!wrong || !json) return root.exit(error) == 0 ? 0 : 2;
    program::SayError(error.what());
    return 2;
  }
  Status status = command();
  if (status.ok()) return 0;
  program::SayError(std::string(Printable(status.message())));
  return 1;
}
