#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "common/program/log.h"
#include "station/app/attempt.h"
#include "station/app/command_line.h"

// The command line of `run`: the way of signing in, and the exit code's meaning for the recording.
namespace enamel::station {
namespace {

// The PIN of a reserved ticket identifies its person when the server is not asked.
bool SignsInByPin(const RunOptions& options) {
  return !options.pin.empty() && (!options.reserved.empty() || !options.resume.empty());
}

// Checks that CLI11 cannot express: which options belong together.
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

// Somebody pressed Enter at this program's terminal.
bool EnterPressed() {
  pollfd keys{STDIN_FILENO, POLLIN, 0};
  if (::poll(&keys, 1, 0) <= 0) return false;
  char line[256];
  return ::read(STDIN_FILENO, line, sizeof line) > 0;
}

int Run(RunOptions& options, bool password_stdin) {
  options.pin = Environment("ENAMEL_PIN");
  options.signer_pin = Environment("ENAMEL_SIGNER_PIN");
  if (Status s = CheckRun(options); !s.ok()) {
    // Reported like a failure, but with exit code 2, as for errors found by the parser.
    (void)Finish(s);
    return kUsage;
  }
  if (!SignsInByPin(options)) {
    auto password = Password(password_stdin);
    if (!password.ok()) return Finish(password.status());
    options.password = *password;
  }
  // A simulated hand finishes by itself. A person at a device has no other way.
  if (::isatty(STDIN_FILENO) != 0 && !options.device.device.empty()) options.finish = EnterPressed;
  auto result = RunAttempt(options);
  if (!result.ok()) return Finish(result.status());
  std::printf("attempt %s\n", result->attempt.Text().c_str());
  std::fflush(stdout);
  if (result->left) {
    const std::string id = result->attempt.Text();
    program::SayWarning("this attempt was left before its end. It is recorded and safe in " +
                        options.workplace.data.string() +
                        ". To continue it: 'enamel-station run "
                        "--resume " +
                        id + "'; to hand it in as it is: 'enamel-station spool close " + id + "'");
    return kNotUploaded;
  }
  if (result->uploaded) return 0;
  // Trying again will not help and somebody has to act, so this is a failure, not "later".
  if (!result->refused.empty()) {
    return Finish(Status(Code::kForbidden,
                         "the server refuses this recording: " + result->refused +
                             ". It is kept in " + options.workplace.data.string() +
                             "; when that is resolved, 'enamel-station spool upload --again " +
                             result->attempt.Text() + "' sends it"));
  }
  program::SayWarning("recorded and safe in " + options.workplace.data.string() +
                      ", but not on the server yet (" + result->not_uploaded_because +
                      "). Run 'enamel-station upload' later: nothing is lost");
  return kNotUploaded;
}

}  // namespace

void DeclareRun(CommandGroup group) {
  struct Options {
    RunOptions run;
    bool password_stdin = false;
  };
  auto options = std::make_shared<Options>();
  RunOptions& run = options->run;
  CLI::App* cmd = group.app.add_subcommand("run", "Make an attempt at an exercise");
  AddWorkplaceSettings(*cmd, group.place);
  cmd->footer(
      "With a simulated hand; with a board and a foot pedal; resuming after a crash:\n"
      "  ENAMEL_PASSWORD=... enamel-station run --user LOGIN --exercise NAME --profile omega3\n"
      "  ENAMEL_PASSWORD=... enamel-station run --user LOGIN --exercise NAME --profile NAME \\\n"
      "      --device hid --pedal 05f3:00ff --window\n"
      "  ENAMEL_PASSWORD=... enamel-station run --user LOGIN --resume last\n"
      "With a device, Enter finishes and hands in. Ctrl-C leaves the attempt, to be resumed.\n"
      "'devices' lists attached devices; 'profiles' and the server's page list profiles.");
  auto* exercise = cmd->add_option("--exercise", run.exercise, "Name of the exercise");
  cmd->add_option("--assignment", run.assignment,
                  "Id of the assignment, if the exercise is assigned more than once")
      ->needs(exercise);
  cmd->add_option("--profile", run.profile, "Name of the device profile");
  cmd->add_option("--user", run.login, "Login of the person at this station");
  auto* resume = cmd->add_option("--resume", run.resume,
                                 "Resume an interrupted attempt: its id ('spool list'), or 'last'")
                     ->excludes(exercise);
  cmd->add_option("--reserved", run.reserved,
                  "Use a ticket taken with 'reserve'; PIN in ENAMEL_PIN")
      ->excludes(exercise)
      ->excludes(resume);
  cmd->add_option("--signer", run.signer,
                  "Login of the instructor who signs start and end of an exam that requires it; "
                  "PIN in ENAMEL_SIGNER_PIN");
  cmd->add_flag("--password-stdin", options->password_stdin,
                "Read the password from standard input (else ENAMEL_PASSWORD)");
  cmd->add_option("--device", run.device.device,
                  "hid or spacemouse, with :VENDOR:PRODUCT where there are several; or a driver, "
                  "such as polhem ('devices' lists them); else a simulated one");
  AddCpu(cmd, run.cpu);
  cmd->add_option("--pedal", run.device.pedal,
                  "Foot pedal, as 05f3:00ff; others with ,id=N,byte=N,mask=HEX");
  cmd->add_option("--axes", run.device.axes, "Which of a board's axes are the scene's x, y, z")
      ->capture_default_str();
  AddOperator(cmd, run.operator_name);
  cmd->add_option("--seed", run.seed, "Of the operator's tremor; 0: the operator's own")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  cmd->add_flag("--lockstep", run.lockstep, "Run as fast as the computer can, not at 1 kHz");
  cmd->add_flag("--window", run.window, "Show the tooth being cut");
  cmd->add_option("--json", run.json, "Write the facts of the attempt to this file");
  cmd->add_flag("--as-reference", run.as_reference, "Meant as a reference cut (instructors)");
  cmd->add_flag("--quiet", run.quiet, "No progress");
  cmd->callback([options, group] {
    options->run.workplace = group.place.Options();
    options->run.log_only = group.settings.log().format == "json";
    group.exit_code = Run(options->run, options->password_stdin);
  });
}

}  // namespace enamel::station
