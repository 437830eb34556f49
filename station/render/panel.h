#pragma once

#include <optional>
#include <string>

#include "station/render/fonts.h"
#include "station/render/frame_state.h"

namespace enamel::station::render {

// How much of the exercise's zones is gone (schemas/score.md, "Zones").
struct ZoneShares {
  double target_percent = 0;
  double leeway_percent = 0;
  double container_mm3 = 0;  // beyond the leeway
};

struct PanelContent {
  std::string heading;
  FrameState state;
  bool has_state = false;  // state is of a tick
  double force_full_scale_n = 3;
  double time_limit_s = 0;
  double mm_per_pixel = 0;          // at the focus, for the scale bar; picture pixels; 0: no bar
  std::optional<ZoneShares> zones;  // none: not to be shown (an exam), or not known
  std::string hint;                 // what keys and mouse do, in one line
  // Why the force is off and what to do, in one sentence: in place of kWarnFault and kWarnDevice,
  // which say less.
  std::string fault;
};

// Text and bars over the picture: timer, force, removed volume, zones, warnings, keys. Into the
// current ImGui frame of a picture of this size.
void DrawPanel(const PanelContent& content, const Fonts& fonts, int width, int height);

// "3:07"; hours only when there are any. Negative counts as 0.
std::string TimerText(double seconds);
// Each warning as a sentence for the person at the chair, one line each; empty for none.
std::string WarningText(uint32_t warnings);
// The same for what is on the panel: the fault in its own words first.
std::string WarningText(const PanelContent& content);

}  // namespace enamel::station::render
