#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/scene/types.h"
#include "common/scoring/metrics.h"
#include "common/scoring/remedies.h"

// Why points were earned or lost, as data that any language can be made of, and the English
// sentence made of it: schemas/score.md, "Reasons". Thread safety: functions, any thread.
// Deterministic.
namespace enamel::scoring {

struct Reason {
  std::string code;
  std::vector<double> values;
  std::vector<std::string> units;  // one for each value

  bool operator==(const Reason&) const = default;
};
inline constexpr size_t kMaxReasons = 4, kMaxReasonValues = 8;

// The value found, with the values where the map gives full marks, and where it gives none if marks
// were lost: "at_most", "at_least", "within", "between" or "any".
Reason FoundReason(const MetricInfo& info, double value,
                   const std::vector<scene::RubricPoint>& map);
// A critical criterion that was failed: "fails_above".
Reason FailsReason(const MetricInfo& info, double value, double limit);
// No value: "not_in_task" or "not_made".
Reason MissingReason(NoValue why);
// A force that the device could not render: "device_limit".
Reason LimitReason(const MetricInfo& info, double value);
// A thickness below what the grid can measure, beside the value found: "below_grid".
Reason BelowGridReason(const MetricInfo& info, double least);
// The metric's fault and remedy on the side where the map gives less; nullptr where the value earns
// full marks, or is no fault.
const Remedy* RemedyOf(const MetricInfo& info, double value,
                       const std::vector<scene::RubricPoint>& map);
// Decimals of a value and its limits, in any language. As fine as anybody acts on: 0.01 mm, a tenth
// of a degree or of a second. More, up to four, only for a limit that they would not show exactly
// (0.025 mm, not 0.03), and for a value that they would show on the wrong side of where full marks end.
int UsualDigits(std::string_view unit);
// Of reason.values[i]: 0 is what was found, the others are its limits.
int ReasonDigits(const Reason& reason, size_t i, std::string_view unit);
// "0.30 mm", "12°", "3" of a count.
std::string WithUnit(std::string number, std::string_view unit);
// Of a signed metric, in its unit: a smaller value shows as 0.00, neither too deep nor short.
inline constexpr double kNeitherWay = 0.005;

// The sentences, each with its full stop: "Light hand: 5.20 N (full marks up to 4.00 N, none from 8.00 N). Press less and
// let the bur cut." A code that is not known, of a newer server, is left out. `comment`: the rubric's, told last; may be empty.
std::string Sentence(std::string_view title, const MetricInfo& info,
                     const std::vector<Reason>& reasons, std::string_view comment);

}  // namespace enamel::scoring
