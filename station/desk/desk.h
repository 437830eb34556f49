#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "common/language/words.h"
#include "station/hid/open_device.h"
#include "station/session/workplace.h"

namespace enamel::station::desk {

// The student's window, from sign-in to result.
struct DeskOptions {
  WorkplaceOptions workplace;
  std::string profile;  // of this station's device, offered first; empty: any
  int cpu = -1;         // bind the haptic loop to this processor; -1: to none
  language::Language language = language::Language::kEnglish;
  bool full_screen = true;
  int width_px = 1280, height_px = 720;  // when not full screen
  std::string monitor;                   // as ScreenOptions::monitor
  std::string quality;       // "best", "good", "fair", "low"; empty: chosen by drawing time
  bool simulated = false;    // offer simulated hands too
  hid::DeviceChoice device;  // pedal, axes and watchdog of attached devices
  // How an attached device stands, seen from above: counter-clockwise from facing the person, in
  // quarters.
  int hand_turn_deg = 0;
  bool left_handed = false;  // until the person who signs in says otherwise
  bool sound = true;
  bool mouth = true;             // draw it around a tooth
  double idle_minutes = 10;      // sign out after this time without input, outside an attempt
  std::filesystem::path script;  // plays a person's part (script.h); empty: none
};

// "1280x720": instead of the full screen. Errors: kInvalidInput.
Status SetWindowSize(const std::string& text, DeskOptions& options);

// Runs until the person closes the window. If the workplace cannot be opened, the window says why
// and tries again on request. Errors: kUnavailable without a display; those of the credentials and
// the spool, if the window was closed with them; those of a script that did not find what it
// expected.
Status RunDesk(const DeskOptions& options);

}  // namespace enamel::station::desk
