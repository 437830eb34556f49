#pragma once

#include <string_view>

// Advice for a hand whose force costs points. Mistakes of the cut have their own advice
// (schemas/words, mistake_do.*). Words: reason.do_*. Thread safety: functions, any thread.
namespace enamel::scoring {

struct Remedy {
  std::string_view fault;  // "heavy_hand"
  std::string_view code;   // "do_lighter"
};

// nullptr where a value of this metric has no remedy on that side, as time and path have none.
const Remedy* FindRemedy(std::string_view metric, bool above);

// The English sentence of a remedy's code, without its full stop; empty for any other code.
std::string_view RemedyText(std::string_view code);

}  // namespace enamel::scoring
