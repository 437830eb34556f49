#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"
#include "common/language/words.h"
#include "station/hid/open_device.h"
#include "station/session/workplace.h"

namespace enamel::station::desk {

// What a student sits at: one window from sign-in to result, and again.
struct DeskOptions {
  WorkplaceOptions workplace;
  std::string profile;  // of this station's device: it is offered first; empty: any
  int cpu = -1;         // bind the haptic loop to this processor; -1: to none
  language::Language language = language::Language::kEnglish;
  bool full_screen = true;
  int width_px = 1280, height_px = 720;  // when not on the full screen
  std::string quality;       // "best", "good", "fair", "low"; empty: by how long pictures take
  bool simulated = false;    // offer simulated hands too
  hid::DeviceChoice device;  // pedal, axes and watchdog of attached devices
  bool sound = true;
  double idle_minutes = 10;      // without a key or the mouse, outside an attempt, signs out
  std::filesystem::path script;  // plays a person's part (script.h); empty: nobody's
};

// "1280x720": instead of the full screen. Errors: kInvalidInput.
Status SetWindowSize(const std::string& text, DeskOptions& options);

// Until the person closes the window. Where the workplace cannot be opened the window says why, and
// tries again when asked. Errors: kUnavailable without a display; the credentials' and the spool's,
// where it was closed with them; a script's that did not find what it expected.
Status RunDesk(const DeskOptions& options);

}  // namespace enamel::station::desk
