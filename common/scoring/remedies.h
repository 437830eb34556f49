#pragma once

#include <string_view>

// What a fault is called, and what mends it next time: by metric and by the side on which its value
// is wrong. Codes of schemas/words (fault.*, reason.do_*). Thread safety: functions, any thread.
namespace enamel::scoring {

struct Remedy {
  std::string_view fault;  // "over_tapered"
  // "do_parallel": what hand or bur does otherwise. kStopEarlier, kCutFurther: the cut ends in the
  // wrong place, so that place, moment and volume say it (reasons.h, Advice).
  std::string_view code;
};
inline constexpr std::string_view kStopEarlier = "stop_earlier", kCutFurther = "cut_further";

// nullptr where a value of this metric is no fault of the cut on that side: time, path, force.
const Remedy* FindRemedy(std::string_view metric, bool above);

// The English sentence of a remedy's code, without its full stop; empty for any other code.
std::string_view RemedyText(std::string_view code);

}  // namespace enamel::scoring
