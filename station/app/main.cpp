#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>

#include "common/program/command_settings.h"
#include "common/program/log.h"
#include "station/app/attempt.h"
#include "station/app/commands.h"
#include "station/app/device_commands.h"
#include "station/app/import_command.h"
#include "station/app/lab_command.h"
#include "station/app/replay.h"
#include "station/app/spool_command.h"
#include "station/app/verify.h"
#include "station/app/workplace_settings.h"
#include "station/desk/desk.h"

namespace {

using namespace enamel;
using namespace enamel::station;

constexpr char kName[] = "enamel-station", kPrefix[] = "ENAMEL_STATION_";
// Exit codes; 2 is for a command line that cannot be understood.
constexpr int kFailed = 1, kUsage = 2, kNotUploaded = 3;

constexpr char kFooter[] = R"(A first attempt, with a server on the same machine:
  enamel-server admin enrol-code --data SERVER_DATA        # prints CODE@FINGERPRINT
  enamel-station enrol --server 127.0.0.1:8443 --code CODE@FINGERPRINT
  enamel-station                                           # the window; sign in there
or without a window, with a simulated hand:
  ENAMEL_PASSWORD=... enamel-station run --user LOGIN \
      --exercise NAME --profile phantom_desktop --operator student
Without any server:
  enamel-station simulate --profile phantom_desktop --operator dentist
What was recorded while the server was away is sent by:
  enamel-station upload
After a crash or a power cut, go on where the recording ends, or end it there:
  ENAMEL_PASSWORD=... enamel-station run --user LOGIN --resume last
  enamel-station spool close last
For hours without the server, with a PIN of your own:
  ENAMEL_PASSWORD=... ENAMEL_PIN=... enamel-station reserve --user LOGIN --exercise NAME --profile NAME
  ENAMEL_PIN=... enamel-station run --reserved ID
  ENAMEL_PIN=... enamel-station reserve --give-back ID
Measuring laws, cutting and this computer is enamel-lab's: qualify, fit-damping, explain and
frame-bench still start it from here. 'enamel-lab --help' teaches it.
Settings: command line before environment (ENAMEL_STATION_ and the option's name, as
ENAMEL_STATION_UPLINK_KBIT) before a file (--config FILE); schemas/station_settings.md.
Exit codes: 0 done, 1 failed (the reason is on standard error), 2 wrong command line,
3 recorded and safe on this station, but not on the server yet.)";

std::string DefaultData() {
  if (const char* set = std::getenv("ENAMEL_STATION_DATA")) return set;
  if (const char* home = std::getenv("HOME"))
    return std::string(home) + "/.local/share/enamel-station";
  return "enamel-station-data";
}

std::string HostName() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 && name[0] != 0 ? name : "station";
}

int Finish(const Status& status) {
  if (status.ok()) return 0;
  std::fflush(stdout);
  program::SayError(status.message());
  return kFailed;
}

std::string Environment(const char* name) {
  const char* set = std::getenv(name);
  return set == nullptr ? "" : set;
}

// The PIN of a reserved ticket stands for its person where the server is not asked.
bool SignsInByPin(const RunOptions& options) {
  return !options.pin.empty() && (!options.reserved.empty() || !options.resume.empty());
}

// What CLI11 cannot say: which options belong together.
Status CheckRun(const RunOptions& options) {
  if (!options.reserved.empty() && options.pin.empty()) {
    return Status(Code::kInvalidInput, "a reserved ticket needs its PIN: set ENAMEL_PIN");
  }
  if (SignsInByPin(options)) return Status::Ok();
  if (options.login.empty())
    return Status(
        Code::kInvalidInput,
        "--user LOGIN is required: who makes the attempt. 'enamel-station --help' shows a "
        "whole one");
  bool begins = options.resume.empty() && options.reserved.empty();
  if (begins && (options.exercise.empty() || options.profile.empty())) {
    return Status(Code::kInvalidInput,
                  "--exercise and --profile are required (or --resume, or --reserved)");
  }
  return Status::Ok();
}

Result<std::string> Password(bool from_stdin) {
  std::string line;
  if (from_stdin) {
    std::getline(std::cin, line);
    return line;
  }
  if (const char* set = std::getenv("ENAMEL_PASSWORD")) return std::string(set);
  return Status(Code::kInvalidInput,
                "no password: set ENAMEL_PASSWORD, or use --password-stdin and write it there");
}

int Run(RunOptions& options, bool password_stdin) {
  options.pin = Environment("ENAMEL_PIN");
  if (Status s = CheckRun(options); !s.ok()) {
    (void)Finish(s);
    return kUsage;
  }
  if (!SignsInByPin(options)) {
    auto password = Password(password_stdin);
    if (!password.ok()) return Finish(password.status());
    options.password = *password;
  }
  auto result = RunAttempt(options);
  if (!result.ok()) return Finish(result.status());
  std::printf("attempt %s\n", result->attempt.Text().c_str());
  std::fflush(stdout);
  if (result->ended_early) {
    program::SayWarning("this attempt was ended early, at " +
                        std::to_string(std::lround(100 * result->done_ratio)) +
                        " % of it. What was done is sealed and will be scored as it is: what was "
                        "not cut counts as missing");
  }
  if (result->uploaded) return 0;
  if (!result->refused.empty()) {
    return Finish(Status(Code::kForbidden,
                         "the server refuses this recording: " + result->refused +
                             ". It is kept in " + options.workplace.data.string() +
                             "; when the cause is gone, 'enamel-station spool upload --again " +
                             result->attempt.Text() + "' sends it"));
  }
  program::SayWarning("recorded and safe in " + options.workplace.data.string() +
                      ", but not on the server yet (" + result->not_uploaded_because +
                      "). Run 'enamel-station upload' later: nothing is lost");
  return kNotUploaded;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("enamel-station: cut virtual teeth; every tick is recorded and sent to the server.");
  app.footer(
      "'enamel-station --help' shows a first attempt, and what exit codes mean.");  // of commands
  app.require_subcommand(0, 1);
  app.set_version_flag("--version", "enamel-station " ENAMEL_VERSION);
  int exit_code = 0;
  const bool json = program::AsksForJson(argc, argv, kPrefix);
  (void)program::SetUpLog({.format = json ? "json" : "text", .name = kName});
  if (IsLabCommand(argc, argv)) return Finish(RunLabCommand(argc, argv));
  program::CommandSettings settings(
      app, {.program = kName, .prefix = kPrefix, .system_file = "/etc/enamel/station.toml"});
  std::string data = DefaultData();
  auto with_data = [&](CLI::App* command) {
    command
        ->add_option("--data", data,
                     "Folder for credentials, spool and cache (also ENAMEL_STATION_DATA)")
        ->capture_default_str();
    return command;
  };

  WorkplaceSettings place;
  place.data = data;
  auto with_cpu = [](CLI::App* command, int& cpu) {
    command->add_option("--cpu", cpu, "Bind the haptic loop to this processor, 0 the first")
        ->check(CLI::Range(0, 1023));
  };

  desk::DeskOptions open;
  std::string size;
  auto* open_cmd =
      app.add_subcommand("open", "The window a student sits at; also without any subcommand");
  AddWorkplaceSettings(*open_cmd, place);
  open_cmd->add_option("--profile", open.profile,
                       "Device profile of this station's device: offered first");
  with_cpu(open_cmd, open.cpu);
  open_cmd->add_option("--window", size, "WIDTHxHEIGHT instead of the full screen, as 1280x720");
  open_cmd->add_option("--quality", open.quality,
                       "best, good, fair or low; else by how long pictures take");
  open_cmd
      ->add_option("--idle-minutes", open.idle_minutes,
                   "Without key or mouse, outside an attempt, before it signs out")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  open_cmd->add_flag("!--no-sound", open.sound, "No sound of the handpiece");
  open_cmd->add_flag("--simulated", open.simulated, "Offer simulated hands as devices too");
  open_cmd->add_option("--pedal", open.device.pedal,
                       "Foot pedal of attached devices when it is none that is known, as "
                       "1a86:e026,id=1,byte=3,mask=ff");
  open_cmd
      ->add_option("--axes", open.device.axes, "Which of a board's axes are the scene's x, y, z")
      ->capture_default_str();
  open_cmd->add_option("--script", open.script,
                       "Play a person's part from this file (station/desk/script.h)");
  auto open_desk = [&] {
    open.workplace = place.Options();
    if (open_cmd->count("--window") > 0) ENAMEL_RETURN_IF_ERROR(desk::SetWindowSize(size, open));
    return desk::RunDesk(open);
  };
  open_cmd->callback([&] { exit_code = Finish(open_desk()); });

  EnrolOptions enrol;
  enrol.name = HostName();
  auto* enrol_cmd =
      with_data(app.add_subcommand("enrol", "Make this machine a station of a server (once)"));
  enrol_cmd->add_option("--server", enrol.server, "HOST:PORT of its station link")->required();
  enrol_cmd
      ->add_option("--code", enrol.code, "CODE@FINGERPRINT from 'enamel-server admin enrol-code'")
      ->required();
  enrol_cmd->add_option("--name", enrol.name, "What to call this station")->capture_default_str();
  enrol_cmd->add_flag(
      "--again", enrol.again,
      "Enrol again as the same station: the server was restored and does not know it; what "
      "is recorded here stays good");
  enrol_cmd->callback([&] {
    enrol.data = data;
    if (enrol.again && enrol_cmd->count("--name") == 0) enrol.name.clear();
    exit_code = Finish(EnrolStation(enrol));
  });

  RunOptions run;
  bool password_stdin = false;
  auto* run_cmd = app.add_subcommand("run", "Make an attempt at an exercise");
  AddWorkplaceSettings(*run_cmd, place);
  run_cmd->footer(
      "With a simulated hand; with a board and a foot pedal; going on after a crash:\n"
      "  ENAMEL_PASSWORD=... enamel-station run --user LOGIN --exercise NAME --profile omega3\n"
      "  ENAMEL_PASSWORD=... enamel-station run --user LOGIN --exercise NAME --profile NAME \\\n"
      "      --device hid --pedal 05f3:00ff --window\n"
      "  ENAMEL_PASSWORD=... enamel-station run --user LOGIN --resume last\n"
      "'devices' lists what is attached, 'profiles' and the server's page what there is.");
  auto* exercise = run_cmd->add_option("--exercise", run.exercise, "Name of the exercise");
  run_cmd->add_option("--profile", run.profile, "Name of the device profile");
  run_cmd->add_option("--user", run.login, "Login of the person at this station");
  auto* resume =
      run_cmd
          ->add_option("--resume", run.resume,
                       "Go on with an attempt that was cut off: its id ('spool list'), or 'last'")
          ->excludes(exercise);
  run_cmd
      ->add_option("--reserved", run.reserved,
                   "Use a ticket taken with 'reserve'; PIN in ENAMEL_PIN")
      ->excludes(exercise)
      ->excludes(resume);
  run_cmd->add_flag("--password-stdin", password_stdin,
                    "Read the password from standard input (else ENAMEL_PASSWORD)");
  run_cmd->add_option("--device", run.device.device,
                      "hid or spacemouse, with :VENDOR:PRODUCT where there are several; dhd, "
                      "openhaptics ('devices' "
                      "lists them); else a simulated one");
  with_cpu(run_cmd, run.cpu);
  run_cmd->add_option("--pedal", run.device.pedal,
                      "Foot pedal, as 05f3:00ff; others with ,id=N,byte=N,mask=HEX");
  run_cmd->add_option("--axes", run.device.axes, "Which of a board's axes are the scene's x, y, z")
      ->capture_default_str();
  run_cmd
      ->add_option("--operator", run.operator_name,
                   "Who holds the simulated device ('devices' lists them)")
      ->capture_default_str();
  run_cmd->add_option("--seed", run.seed, "Of the operator's tremor; 0: his own")
      ->capture_default_str();
  run_cmd->add_flag("--lockstep", run.lockstep, "As fast as the machine can instead of 1 kHz");
  run_cmd->add_flag("--window", run.window, "Show the tooth being cut");
  run_cmd->add_option("--screenshot", run.screenshot, "Write the last picture as PNG");
  run_cmd->add_option("--json", run.json, "Write the facts of the attempt to this file");
  run_cmd->add_flag("--as-reference", run.as_reference, "Meant as a reference cut (instructors)");
  run_cmd->add_flag("--quiet", run.quiet, "No progress");
  run_cmd->callback([&] {
    run.workplace = place.Options();
    run.log_only = settings.log().format == "json";
    exit_code = Run(run, password_stdin);
  });

  SpoolCommand spool;
  AddSpoolCommands(app, spool, place, [&](const Status& status) { exit_code = Finish(status); });

  ReserveCommand reserve;
  auto* reserve_cmd = app.add_subcommand(
      "reserve", "Take a ticket now for an attempt within 12 hours, with or without the server");
  AddWorkplaceSettings(*reserve_cmd, place);
  reserve_cmd->add_option("--exercise", reserve.exercise, "Name of the exercise");
  reserve_cmd->add_option("--profile", reserve.profile, "Name of the device profile");
  reserve_cmd->add_option("--user", reserve.login, "Login of the person at this station");
  std::string give_back;
  reserve_cmd->add_option("--give-back", give_back,
                          "ID of a reserved attempt that is not wanted any more: it then does not "
                          "count.\nPIN in ENAMEL_PIN; forgotten: --user and ENAMEL_PASSWORD");
  reserve_cmd->footer(
      "Password in ENAMEL_PASSWORD, PIN (6 to 12 digits) in ENAMEL_PIN. Without --exercise it "
      "lists "
      "what is reserved here.\n'run --reserved ID' with ENAMEL_PIN makes the attempt. The PIN "
      "keeps "
      "others at this chair from using it;\nwho can read this station's disk is not kept out by "
      "six "
      "digits. Exams cannot be reserved.");
  reserve_cmd->callback([&] {
    reserve.workplace = place.Options();
    reserve.password = Environment("ENAMEL_PASSWORD");
    reserve.pin = Environment("ENAMEL_PIN");
    if (!give_back.empty()) {
      exit_code = Finish(GiveBackReserved(
          {reserve.workplace, give_back, reserve.login, reserve.password, reserve.pin}));
      return;
    }
    exit_code =
        Finish(reserve.exercise.empty() ? ListReserved(place.data) : ReserveAttempt(reserve));
  });

  ReplayOptions replay;
  auto* replay_cmd = with_data(
      app.add_subcommand("replay", "Re-run the core on an exported recording and compare"));
  replay_cmd->add_option("trace", replay.trace, "File from 'spool export'")->required();
  replay_cmd->add_option("--volume", replay.volume,
                         "The tooth it began with, when it is not in the cache");
  replay_cmd->add_option("--to-tick", replay.to_tick,
                         "Stop after this many ticks, starting from the keyframe before");
  replay_cmd->add_option("--surface", replay.surface,
                         "Write the tooth's surface there as PLY (mm, tissue per vertex)");
  replay_cmd->add_flag("!--no-keyframes", replay.keyframes,
                       "Neither use nor write TRACE.keyframes, the cache beside the trace");
  replay_cmd->add_option("--json", replay.json, "Write what was found to this file");
  replay_cmd->callback([&] {
    replay.data = data;
    exit_code = Finish(ReplayTrace(replay));
  });

  VerifyOptions verify;
  auto* verify_cmd = with_data(app.add_subcommand(
      "verify",
      "Check an exported recording: ticket, signatures, chain, seal, and every tick again"));
  verify_cmd->add_option("trace", verify.trace, "File from 'spool export'")->required();
  verify_cmd->add_option("--station-key", verify.station_key,
                         "Public key of the station, 64 hexadecimal digits or a file; this "
                         "station's own if left out");
  verify_cmd->add_option("--server-key", verify.server_key,
                         "Public key of the server's tickets, likewise");
  verify_cmd->add_option("--volume", verify.volume,
                         "The tooth it began with, when it is not in the cache");
  verify_cmd->add_option("--json", verify.json, "Write what was found to this file");
  verify_cmd->callback([&] {
    verify.data = data;
    exit_code = Finish(VerifyRecording(verify));
  });

  ImportCommand import;
  AddImportCommand(app, import)->callback([&] { exit_code = Finish(ImportMesh(import)); });

  SimulateCommand simulate;
  auto* simulate_cmd =
      app.add_subcommand("simulate", "An attempt without any server: walls, forces, ticks");
  simulate_cmd
      ->add_option("--scene", simulate.scene,
                   "builtin:molar, builtin:block, or an imported scene's folder")
      ->capture_default_str();
  simulate_cmd
      ->add_option("--profile", simulate.profile, "Device profile, or its document (FILE.json)")
      ->capture_default_str();
  simulate_cmd->add_option("--operator", simulate.operator_name, "Who holds the device")
      ->capture_default_str();
  simulate_cmd->add_option("--voxel-um", simulate.voxel_um, "Voxel of a built-in scene")
      ->capture_default_str();
  simulate_cmd->add_option("--seed", simulate.seed, "Of the tremor; 0: the operator's own")
      ->capture_default_str();
  simulate_cmd->add_option("--json", simulate.json, "Write the facts to this file");
  simulate_cmd->callback([&] { exit_code = Finish(SimulateAttempt(simulate)); });

  app.add_subcommand("scenes", "Built-in scenes and their exercises")->callback([] {
    PrintScenes();
  });
  app.add_subcommand("profiles", "Device profiles and where their numbers are from")->callback([] {
    PrintProfiles();
  });

  RegisterDeviceCommands(app, DefaultData(), Finish, &exit_code);

  app.footer(kFooter);
  settings.Add();
  try {
    app.parse(argc, argv);
    if (app.get_subcommands().empty()) {
      Status set = settings.Apply(*open_cmd);
      exit_code = Finish(set.ok() ? open_desk() : set);
    }
  } catch (const CLI::ParseError& error) {
    const bool wrong = error.get_exit_code() != 0;
    if (!wrong || !json) return app.exit(error) == 0 ? 0 : kUsage;
    program::SayError(error.what());
    return kUsage;
  } catch (const std::exception& error) {
    program::SayError(error.what());
    return kFailed;
  }
  return exit_code;
}
