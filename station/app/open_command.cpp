#include <cstdlib>

#include "common/program/example.h"
#include "common/protocol/station_policy.h"
#include "station/app/command_line.h"
#include "station/desk/desk.h"

namespace enamel::station {
namespace {

struct OpenOptions {
  desk::DeskOptions desk;
  std::string size, language, hand = "right";
};

CLI::IsMember IsOneOf(std::string_view setting) {
  const auto& texts = protocol::PolicyRuleOf(setting).texts;
  return CLI::IsMember(std::vector<std::string>(texts.begin(), texts.end()));
}

// The requested language, else the computer's.
language::Language LanguageFor(const std::string& asked) {
  if (auto named = language::LanguageOf(asked)) return *named;
  for (const char* name : {"LC_ALL", "LC_MESSAGES", "LANG"}) {
    const char* value = std::getenv(name);
    if (value == nullptr || *value == 0) continue;
    // The first variable that is set decides, as in POSIX.
    return language::LanguageOf(value).value_or(language::Language::kEnglish);
  }
  return language::Language::kEnglish;
}

}  // namespace

OpenCommand DeclareOpen(CommandGroup group) {
  auto options = std::make_shared<OpenOptions>();
  desk::DeskOptions& o = options->desk;
  CLI::App* cmd = group.app.add_subcommand(
      "open", "The window a student sits at; its options do without the word, too");
  AddWorkplaceSettings(*cmd, group.place);
  cmd->add_option("--profile", o.profile, "Device profile of this station's device: offered first");
  AddCpu(cmd, o.cpu);
  cmd->add_option("--window", options->size, "WIDTHxHEIGHT instead of the full screen, as 1280x720")
      ->check([](const std::string& text) {
        desk::DeskOptions size;
        return desk::SetWindowSize(text, size).message();
      });
  cmd->add_option(
      "--monitor", o.monitor,
      "Monitor to be on: its name, as HDMI-1, or its number, 0 the primary one; without "
      "this option or that monitor the primary one");
  cmd->add_option("--language", options->language,
                  "en, de or zh: the window's language until somebody chooses another; else LANG")
      ->check(IsOneOf("language"));
  cmd->add_option("--quality", o.quality,
                  "best, good, fair or low; else chosen by how long pictures take")
      ->check(IsOneOf("quality"));
  cmd->add_option("--idle-minutes", o.idle_minutes,
                  "Time without key or mouse, outside an attempt, before it signs out")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  cmd->add_flag("!--no-sound", o.sound, "Play no handpiece sound");
  cmd->add_flag("!--no-mouth", o.mouth, "Draw teeth alone, without gingiva and neighbours");
  cmd->add_flag("--simulated", o.simulated, "Offer simulated hands as devices too");
  cmd->add_option("--pedal", o.device.pedal,
                  "Foot pedal of attached devices when it is none that is known, as "
                  "1a86:e026,id=1,byte=3,mask=ff");
  cmd->add_option("--axes", o.device.axes, "Which of a board's axes are the scene's x, y, z")
      ->capture_default_str();
  cmd->add_option("--hand-turn", o.hand_turn_deg,
                  "Degrees, 0, 90, 180 or 270, by which an attached device stands turned "
                  "counter-clockwise, seen from above, from facing the person")
      ->check(IsOneOf("hand-turn"))
      ->capture_default_str();
  cmd->add_option("--hand", options->hand,
                  "Hand that holds the handpiece, right or left, until somebody chooses the other: "
                  "panel, buttons and tooth change sides")
      ->check(CLI::IsMember({"right", "left"}))
      ->capture_default_str();
  cmd->add_option("--script", o.script,
                  "Play a person's part from this file (station/desk/script.h)");
  program::AddExamples(*cmd, {"--data /var/lib/enamel-station", "--window 1280x720 --simulated"});
  // Also returned, because `main` runs it if no subcommand was named.
  auto run = [options, cmd, &place = group.place]() -> Status {
    options->desk.workplace = place.Options();
    options->desk.language = LanguageFor(options->language);
    options->desk.left_handed = options->hand == "left";
    if (cmd->count("--window") > 0) {
      ENAMEL_RETURN_IF_ERROR(desk::SetWindowSize(options->size, options->desk));
    }
    return desk::RunDesk(options->desk);
  };
  cmd->callback([run, &exit_code = group.exit_code] { exit_code = Finish(run()); });
  return {cmd, run};
}

}  // namespace enamel::station
