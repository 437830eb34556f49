#pragma once

#include <string_view>
#include <vector>

// Faults and their remedies, by metric and by the side on which its value is wrong. Words:
// schemas/words, reason.do_*. Thread safety: functions, any thread.
namespace enamel::scoring {

struct Remedy {
  std::string_view fault;  // "over_tapered"
  // "do_parallel": what hand or bur does otherwise. kStopEarlier, kCutFurther: the cut ends in the
  // wrong place, so that place, moment and volume say it (reasons.h, Advice). kWhereMost: one of these
  // two, of the side where more is wrong; the metric does not tell the sides apart.
  std::string_view code;
};
inline constexpr std::string_view kStopEarlier = "stop_earlier", kCutFurther = "cut_further",
                                  kWhereMost = "where_most";

// nullptr where a value of this metric has no remedy on that side, as time and path have none.
const Remedy* FindRemedy(std::string_view metric, bool above);

// Every fault once, in the order in which a score measures them, with every remedy that some metric
// gives it.
struct KnownFault {
  std::string_view fault;
  std::vector<std::string_view> remedies;
};
std::vector<KnownFault> KnownFaults();

// The English sentence of a remedy's code, without its full stop; empty for any other code.
std::string_view RemedyText(std::string_view code);

}  // namespace enamel::scoring
