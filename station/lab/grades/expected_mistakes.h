#pragma once

#include <string>
#include <vector>

#include "common/scoring/mistakes/mistakes.h"
#include "station/lab/grades/faults.h"

// What an instructor would call each known fault. Written down from the faults, not from what the
// score says of them. Thread safety: functions, any thread.
namespace enamel::station::lab {

struct ExpectedMistake {
  scoring::MistakeKind kind = scoring::MistakeKind::kUneven;
  // The beginning of the place's name: "floor" is "floor_1" too. Empty: the whole. kAnyPlace: any.
  std::string place;

  bool Is(const scoring::Mistake& mistake) const;
};
inline constexpr std::string_view kAnyPlace = "*";

// Any of them is right. None where there is nothing to name, and for critical errors, which are called by their own
// names.
std::vector<ExpectedMistake> ExpectedMistakesOf(const std::string& exercise, const Fault& fault);

}  // namespace enamel::station::lab
