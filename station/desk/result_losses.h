#pragma once

#include <string>
#include <vector>

#include "common/language/words.h"
#include "common/scoring/score.h"

namespace enamel::station::desk {

// One of the things that cost most. Points into the score.
struct Loss {
  const scoring::GateResult* gate = nullptr;  // one of both
  const scoring::CriterionResult* criterion = nullptr;
  // Its largest place on the tooth, first one with a stroke; none: it has none.
  const scoring::Deduction* place = nullptr;

  const std::string& title() const { return gate != nullptr ? gate->title : criterion->title; }
  double points() const {  // that a criterion lost
    return criterion != nullptr ? criterion->max_points - criterion->points : 0;
  }
};

inline constexpr size_t kLossesShown = 3;
// Half of the tenth that is shown: "10 of 10" with a reason would be puzzling.
inline constexpr double kLossShown = 0.05;

// The dearest first: what takes points of every criterion, then the criteria that lost most; at most
// kLossesShown. `score` outlives them.
std::vector<Loss> DearestLosses(const scoring::ScoreResult& score);

// The one thing to work on next: the dearest loss. Empty: nothing lost any.
std::string NextStep(const language::Words& words, const scoring::ScoreResult& score);

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
