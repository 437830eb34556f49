#pragma once

#include <string>
#include <vector>

#include "common/language/words.h"
#include "common/scoring/score.h"

namespace enamel::station::desk {

// A mistake that cost points, and where it is shown. Points into the score.
struct Loss {
  const scoring::Mistake* mistake = nullptr;
  // Its largest place on the tooth, first one with a stroke; none: it has none.
  const scoring::Deduction* place = nullptr;
};

inline constexpr size_t kLossesShown = 3;
// Half of the tenth that is shown: "−0" with a reason would be puzzling.
inline constexpr double kLossShown = 0.05;

// The mistakes worth advice (scoring::kWorthAdvice), the dearest first. `score` outlives them.
std::vector<Loss> LossesOf(const scoring::ScoreResult& score);

// How many mistakes were made, above the first of them.
std::string CountText(const language::Words& words, const scoring::ScoreResult& score);

// Beside what cost them: "−4.2", or "0".
std::string LostText(const language::Words& words, double points);

// The stroke that did most of it: "Stroke 14, at 1:12"; empty: none did.
std::string StrokeText(const language::Words& words, const scoring::Deduction& place);

// What the ring marks: "Stroke 14, at 1:12", or that too much was left there.
std::string PlaceOfLossText(const language::Words& words, const scoring::Deduction& place);

// A stroke is shown from this long before it begins, to see where the bur comes from, until this
// long after it ends. One that lasts longer than kLongestShown_s is shown around the moment by which
// half was gone.
inline constexpr double kBeforeStroke_s = 1.5, kAfterStroke_s = 0.5, kLongestShown_s = 8;

// Its ticks, counted from 0 without gaps. Empty and at the recording's end where nothing was cut.
struct ShownTicks {
  uint64_t from = UINT64_MAX, to = UINT64_MAX;
  bool operator==(const ShownTicks&) const = default;
};
ShownTicks TicksToShow(const scoring::Deduction& place, uint32_t rate_hz);

}  // namespace enamel::station::desk
