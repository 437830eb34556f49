#include "common/program/example.h"
#include "station/app/calibrate.h"
#include "station/app/command_line.h"
#include "station/app/devices.h"
#include "station/app/doctor.h"
#include "station/app/first_hour/command.h"
#include "station/app/loop_test.h"

namespace enamel::station {
namespace {

void AddDevices(CommandGroup group) {
  auto options = std::make_shared<DevicesCommand>();
  options->data = group.place.data;
  auto* command = group.app.add_subcommand(
      "devices", "List attached devices, and those that are always available");
  command->add_flag("--all", options->all, "Also HID devices that are not known here");
  command->add_option("--json", options->json, "Write the list to this file");
  command->add_option("--data", options->data, "The station's folder, for what was measured here")
      ->capture_default_str();
  program::AddExamples(*command, {""});
  command->callback([=] { group.exit_code = Finish(ListDevices(*options)); });
}

void AddCalibrate(CommandGroup group) {
  auto options = std::make_shared<CalibrateCommand>();
  options->data = group.place.data;
  auto* command = group.app.add_subcommand(
      "calibrate", "Measure a haptic device with its own motors and propose a profile for it");
  command->footer(
      "An example that needs no device:\n"
      "  enamel-station calibrate --device simulated:omega3 --out profile.json\n"
      "An attached board, found by 'enamel-station devices':\n"
      "  enamel-station calibrate --device hid:1209:0001 --calibration today.json --out mine.json");
  command
      ->add_option(
          "--device", options->device,
          "hid, hid:VENDOR:PRODUCT, a driver (dhd, polhem, …) or simulated:PROFILE (a name or a "
          ".json file)")
      ->capture_default_str();
  command->add_option("--profile", options->profile,
                      "Profile to compare with; else the device's own");
  command->add_option("--rate", options->rate_hz, "Hz it is read and driven at")
      ->check(CLI::Range(500, 8000))
      ->capture_default_str();
  command->add_option("--max-force", options->max_force_n, "N it may use")
      ->check(CLI::Range(0.1, 20.0))
      ->capture_default_str();
  command->add_option("--name", options->name, "Name of the proposed profile");
  command->add_option("--out", options->out, "Write the proposed profile to this file");
  command->add_option("--calibration", options->calibration, "Write the measurement to this file");
  command->add_option("--data", options->data,
                      "The station's folder, for its name and for what attempts find of it");
  command->add_flag("--yes", options->yes, "It may move at once: nobody is near it");
  command->callback([=] { group.exit_code = Finish(CalibrateDevice(*options)); });
}

void AddFirstHour(CommandGroup group) {
  auto options = std::make_shared<FirstHourCommand>();
  auto* command = group.app.add_subcommand(
      "first-hour",
      "Go through the first hour with a new haptic device, and write down what is found");
  command->footer(
      "An example that needs no device; a simulated person does what each step asks:\n"
      "  enamel-station first-hour --device simulated:omega3 --out hour.json\n"
      "A unit on the table, on a terminal beside it:\n"
      "  enamel-station first-hour --device dhd --out hour.json\n"
      "Each step says what to do and waits for you. Type skip and a reason to leave one out. The "
      "motors\n"
      "push only after you have typed yes, and never with more than --max-force. Ctrl-C ends the "
      "hour "
      "and\n"
      "keeps what was found.\n"
      "--answers FILE has a line for each question, \"homing.did: in the pit\", or \"workspace.end "
      "@20:\" for an\n"
      "answer after 20 s. It cannot let a real unit push: that yes is typed.");
  command
      ->add_option(
          "--device", options->device,
          "hid, hid:VENDOR:PRODUCT, a driver (dhd, polhem, …) or simulated:PROFILE (a name "
          "or a .json file)")
      ->required();
  command->add_option("--profile", options->profile,
                      "Profile to compare with; else the device's own");
  command->add_option("--out", options->out, "Write what is found to this file")->required();
  command->add_option("--max-force", options->max_force_n, "N that its motors may use")
      ->check(CLI::Range(0.1, 20.0))
      ->capture_default_str();
  command->add_option("--answers", options->answers, "Take the answers from this file");
  command->callback([=] { group.exit_code = Finish(RunFirstHour(*options)); });
}

void AddDoctor(CommandGroup group) {
  auto options = std::make_shared<DoctorCommand>();
  options->data = group.place.data;
  auto* command = group.app.add_subcommand(
      "doctor", "Check everything that an attempt needs and say what to do about it");
  command->add_option("--data", options->data, "The station's folder")->capture_default_str();
  command->add_option("--server", options->server,
                      "HOST:PORT, if the server has moved since enrolment");
  command->add_flag("!--no-graphics", options->graphics, "For a station without a window");
  command->add_option("--json", options->json, "Write the findings to this file");
  program::AddExamples(*command, {"--data /var/lib/enamel-station"});
  command->callback([=] {
    options->own_settings = group.settings.own();
    group.exit_code = Finish(Doctor(*options));
  });
}

void AddLoopTest(CommandGroup group) {
  auto options = std::make_shared<LoopTestCommand>();
  auto* command = group.app.add_subcommand(
      "loop-test",
      "Measure what a tick of the haptic loop costs on this computer, and how punctual it is");
  command
      ->add_option(
          "--seconds", options->seconds,
          "Of taking turns, 5 s each: at least two turns of a bare sleep and two of the loop")
      ->check(CLI::Range(20, 86'400))
      ->capture_default_str();
  command->add_option("--rate", options->rate_hz, "Hz")
      ->check(CLI::Range(100, 20'000))
      ->capture_default_str();
  command->add_option("--cpu", options->cpu, "Bind both to this processor, 0 the first")
      ->check(CLI::Range(0, 1023));
  command->add_option("--json", options->json, "Write the figures to this file");
  command->footer(
      "What is good, at 1000 Hz for a device with motors:\n"
      "  own cost      below 5000 ns a tick, so that a tick has its time for the tooth\n"
      "  p99           below 200 us late\n"
      "  a period or more late: none in a quiet turn. 21 such ticks within a second, or one late "
      "by\n"
      "                5 ms, take the force away until the bur is in free air\n"
      "  loop against bare sleep: within 10 us, or within what bare differs from bare. When both "
      "are\n"
      "                bad it is the computer: close other programs, let the station have "
      "real-time\n"
      "                priority ('enamel-station doctor' says how), bind it with --cpu. When only "
      "the\n"
      "                loop is bad, report it with --json.\n"
      "Late ticks are harmless with a mouse; they are still recorded.");
  program::AddExamples(*command, {"--seconds 60"});
  command->callback([=] { group.exit_code = Finish(TestLoop(*options)); });
}

}  // namespace

void DeclareDeviceCommands(CommandGroup group) {
  AddDevices(group);
  AddCalibrate(group);
  AddFirstHour(group);
  AddDoctor(group);
  AddLoopTest(group);
}

}  // namespace enamel::station
