#pragma once

#include <cstdint>

#include "common/language/words.h"
#include "station/desk/ui.h"
#include "station/loop/tick_loop.h"
#include "station/render/panel.h"

// What a person sees at a glance, from a metre away, while the force is off or nothing may be cut.
namespace enamel::station::desk {

enum class Stop : uint8_t {
  kNone,
  kUnplugged,  // or silent: its cable comes first
  kPower,      // the device has switched its force off
  kBusy,       // the computer was late
  kHolder,     // the handpiece is in its holder
  kDisk,       // nothing is stored
  kPaused
};

// A fault comes first, then the disk. `disk_full`: nothing is stored at the moment.
Stop StopOf(Fault fault, bool put_down, bool disk_full);

// Of a page at the reference height; its letters are 34 px high.
inline constexpr float kSign_px = 150;

// Its sign, a disc in red, or in blue where nothing is wrong. Draws into the current ImGui window.
void DrawStopSign(Stop stop, const Rect& at);

// The sign large over the picture, with what to do in pictures beside it; `held`, that the cut is
// kept, is written below where it is not empty. In the current ImGui frame; nothing for kNone.
void DrawStop(Stop stop, const std::string& held, const render::Fonts& fonts,
              const render::Canvas& canvas);

}  // namespace enamel::station::desk
