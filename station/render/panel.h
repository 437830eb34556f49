#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "common/language/words.h"
#include "station/render/fonts.h"
#include "station/render/frame_state.h"

namespace enamel::station::render {

using language::Words;

// How much of the exercise's zones was removed (schemas/score.md, "Zones").
struct ZoneShares {
  double target_percent = 0;
  double leeway_percent = 0;
  double beyond_mm3 = 0;     // removed beyond the leeway, anywhere; neighbours too
  double neighbour_mm3 = 0;  // of it, from neighbouring teeth
};

// Distance of the cut from what must stay.
struct Reach {
  struct Leeway {
    double left_mm = 0;  // to its end; below zero: beyond it
    double whole_mm = 0;
    std::string_view where;  // the nearest end, a key: "reach.mesial_wall"; empty: all is left
  };
  std::optional<Leeway> leeway;
  std::optional<double> pulp_mm;  // thickness over the pulp at its thinnest
};
// Thicker is shown as "more than this": no cause for concern under a filling.
inline constexpr double kPulpFar_mm = 2;
// Thinner is too thin (design of the score: critical).
inline constexpr double kPulpThin_mm = 0.5;

// The meaning of a bar's colour; the colours also differ in brightness.
enum class Bearing { kGood, kCareful, kBad };
// sRGB, 0..1.
std::array<float, 3> ColourOf(Bearing bearing);
Bearing BearingOf(const Reach::Leeway& leeway);
Bearing BearingOfPulp(double left_mm);

struct PanelContent {
  std::string heading;
  FrameState state;
  bool has_state = false;  // state is of a tick
  bool recorded = true;    // false: nothing is stored at the moment
  double force_full_scale_n = 3;
  double time_limit_s = 0;
  double mm_per_pixel = 0;            // at the focus, for the scale bar; picture pixels; 0: no bar
  std::optional<ZoneShares> zones;    // none: not to be shown (an exam), or not known
  Reach reach;                        // empty: not to be shown, or not known
  std::optional<glm::vec2> bur_away;  // where it left the picture (Camera::Away)
  bool several_burs = false;          // a choice of burs is shown on the other side (ChoiceWidth)
  std::string hint;                   // what keys and mouse do
  // Why the force is off and what to do, in one sentence: replaces kWarnFault and kWarnDevice,
  // which are less specific.
  std::string fault;
};

// Takes away what the recording does not have: while nothing is stored, no progress is shown.
void HideProgress(PanelContent& content);

// A picture with words over it, window pixels. The panel is at its left, and at its right for a hand
// that holds the handpiece in the left.
struct Canvas {
  int width = 0, height = 0;
  bool left_handed = false;
  float floor = 0;  // where the line of keys begins, at the bottom
};

// Text and bars over the picture: timer, force, zones, limits, removed volume, warnings, keys. Bars
// can be read from two metres. Where there is no room for all of it, the volumes of the tissues become
// one, then the heading and the last of the keys are left out. Draws into the current ImGui frame.
// Returns the canvas with its floor.
Canvas DrawPanel(const PanelContent& content, const Words& words, const Fonts& fonts,
                 Canvas canvas);

// A part of a canvas's width.
struct Span {
  float from = 0, to = 0;
  float middle() const { return 0.5f * (from + to); }
};
// The part that the panel leaves free.
Span BesidePanel(const Fonts& fonts, const Canvas& canvas);
// Width of a choice of burs, which is at the edge of the canvas that is away from the panel.
float ChoiceWidth(const Fonts& fonts, const Canvas& canvas);

// A hint whose lines break only where several spaces part two keys: a key and what it does stay
// together.
std::string Unbroken(const std::string& hint);
// A hint without its last key; empty where it has but one.
std::string WithoutLastKey(const std::string& hint);
// "3:07"; hours only when there are any. Negative counts as 0.
std::string TimerText(double seconds);
// Each warning as a sentence for the person at the chair, one line each; empty for none.
std::string WarningText(const Words& words, uint32_t warnings);
// As above for the panel: its fault comes first.
std::string WarningText(const Words& words, const PanelContent& content);

}  // namespace enamel::station::render
