#include <sodium.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <iostream>

#include "server/app/admin.h"
#include "server/app/report.h"
#include "server/app/seed.h"
#include "server/app/serve.h"

// enamel-server: command line only. Exit codes: 0 done, 1 refused or failed, 2 wrong usage.
namespace {

using namespace enamel;
using namespace enamel::server;

using Command = std::function<Status()>;

// Options live as long as the parser, so they are kept here.
struct Options {
  std::filesystem::path data;
  app::ServeOptions serve;
  app::SeedOptions seed;
  app::ReportOptions report;
  app::NewPerson person;
  app::NewExercise exercise;
  std::string login, cohort, attempt, dentist;
  bool password_from_stdin = false;
  int valid_minutes = 60;
  uint32_t limit = 50;
};

void AddServe(CLI::App& root, Options& o, Command& command) {
  auto* cmd = root.add_subcommand("serve", "Run the server until Ctrl-C");
  cmd->add_option("--data", o.data, "Data folder; made when absent")->required();
  cmd->add_option("--http", o.serve.http, "Page and API: address:port")->capture_default_str();
  cmd->add_option("--stations", o.serve.stations, "Station link: address:port")
      ->capture_default_str();
  cmd->add_option("--web", o.serve.web, "Folder of the built page (web/dist)");
  auto* certificate =
      cmd->add_option("--http-cert", o.serve.http_certificate, "PEM; needed beyond loopback");
  auto* key = cmd->add_option("--http-key", o.serve.http_key, "PEM");
  certificate->needs(key);
  key->needs(certificate);
  cmd->add_option("--host-name", o.serve.host_names, "Name the page is reached under (repeatable)");
  cmd->add_option("--job-threads", o.serve.job_threads, "Attempts scored at once; 0: scoring waits")
      ->check(CLI::Range(0, 64))
      ->capture_default_str();
  cmd->callback([&] {
    command = [&] {
      o.serve.data = o.data;
      return app::Serve(o.serve);
    };
  });
}

void AddSeed(CLI::App& root, Options& o, Command& command) {
  auto* cmd =
      root.add_subcommand("seed-demo", "Demo people, profiles, molar and exercise; idempotent");
  cmd->add_option("--data", o.data)->required();
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
  cmd->add_option("--data", o.data)->required();
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
  add->add_option("--data", o.data)->required();
  add->add_option("--login", o.person.login)->required();
  add->add_option("--name", o.person.display_name, "Name as shown");
  add->add_option("--role", o.person.role, "student, instructor or admin")->required();
  add->add_flag("--password-stdin", o.person.password_from_stdin,
                "Read the password; else one is made up");
  add->callback([&] { command = [&] { return app::AddPerson(o.data, o.person); }; });

  auto* password =
      admin.add_subcommand("set-password", "Set a password; ends the person's sessions");
  password->add_option("--data", o.data)->required();
  password->add_option("--login", o.login)->required();
  password->add_flag("--password-stdin", o.password_from_stdin,
                     "Read the password; else one is made up");
  password->callback(
      [&] { command = [&] { return app::SetPassword(o.data, o.login, o.password_from_stdin); }; });

  for (bool disabled : {true, false}) {
    auto* cmd =
        admin.add_subcommand(disabled ? "disable" : "enable", "Let a person sign in or not");
    cmd->add_option("--data", o.data)->required();
    cmd->add_option("--login", o.login)->required();
    cmd->callback([&o, &command, disabled] {
      command = [&o, disabled] { return app::SetDisabled(o.data, o.login, disabled); };
    });
  }

  auto* cohort = admin.add_subcommand("add-cohort", "Add a cohort");
  cohort->add_option("--data", o.data)->required();
  cohort->add_option("--name", o.cohort)->required();
  cohort->callback([&] { command = [&] { return app::AddCohort(o.data, o.cohort); }; });

  auto* member = admin.add_subcommand("add-to-cohort", "Add a student or instructor to a cohort");
  member->add_option("--data", o.data)->required();
  member->add_option("--cohort", o.cohort)->required();
  member->add_option("--login", o.login)->required();
  member->callback([&] { command = [&] { return app::AddToCohort(o.data, o.cohort, o.login); }; });
}

void AddContent(CLI::App& admin, Options& o, Command& command) {
  auto* code = admin.add_subcommand("enrol-code", "One-time code for a station: CODE@FINGERPRINT");
  code->add_option("--data", o.data)->required();
  code->add_option("--minutes", o.valid_minutes, "How long it can be used")
      ->check(CLI::Range(1, 7 * 24 * 60))
      ->capture_default_str();
  code->callback([&] { command = [&] { return app::EnrolCode(o.data, o.valid_minutes); }; });

  auto* publish = admin.add_subcommand("publish-exercise", "Offer the class I exercise on a scene");
  publish->add_option("--data", o.data)->required();
  publish->add_option("--scene", o.exercise.scene, "Scene folder, or builtin:molar")->required();
  publish->add_option("--cohort", o.exercise.cohort, "For whom; without: everybody");
  publish->add_option("--voxel-um", o.exercise.voxel_um, "Voxel size of a built-in scene")
      ->check(CLI::Range(20, 500))
      ->capture_default_str();
  publish->callback([&] { command = [&] { return app::PublishExercise(o.data, o.exercise); }; });

  auto* mark =
      admin.add_subcommand("mark-reference", "Make a scored attempt its exercise's reference");
  mark->add_option("--data", o.data)->required();
  mark->add_option("--attempt", o.attempt)->required();
  mark->add_option("--dentist", o.dentist, "Name to be shown, with consent")->required();
  mark->callback(
      [&] { command = [&] { return app::MarkReference(o.data, o.attempt, o.dentist); }; });

  auto* release = admin.add_subcommand("release", "Let the student see a graded score");
  release->add_option("--data", o.data)->required();
  release->add_option("--attempt", o.attempt)->required();
  release->callback([&] { command = [&] { return app::ReleaseScore(o.data, o.attempt); }; });

  auto* list = admin.add_subcommand("list-attempts", "Newest attempts first");
  list->add_option("--data", o.data)->required();
  list->add_option("--limit", o.limit)->check(CLI::Range(1, 200))->capture_default_str();
  list->callback([&] { command = [&] { return app::ListAttempts(o.data, o.limit); }; });
}

}  // namespace

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("enamel-server"));
  if (sodium_init() < 0) {
    std::cerr << "enamel-server: libsodium cannot be initialised on this machine\n";
    return 1;
  }
  Options options;
  Command command;
  CLI::App root("Enamel server: station link, storage, scoring, API and page");
  root.require_subcommand(1);
  AddServe(root, options, command);
  AddSeed(root, options, command);
  AddReport(root, options, command);
  auto* admin = root.add_subcommand("admin", "People, cohorts, stations, exercises, references");
  admin->require_subcommand(1);
  AddPeople(*admin, options, command);
  AddContent(*admin, options, command);
  try {
    root.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return root.exit(error) == 0 ? 0 : 2;
  }
  Status status = command();
  if (status.ok()) return 0;
  std::cerr << "enamel-server: " << status.message() << "\n";
  return 1;
}
