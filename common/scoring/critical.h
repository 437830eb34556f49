#pragma once

#include <span>
#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "common/scoring/metrics.h"

// The errors that no examiner passes: schemas/critical_errors.json, with the exercises they belong
// to. The rubric says which metric shows each, and from where on. Thread safety: functions, any
// thread. Deterministic.
namespace enamel::scoring {

struct CriticalError {
  std::string_view code;  // "contact_left"
  std::string_view said;  // to the student, without a full stop
};
std::span<const CriticalError> CriticalErrors();
const CriticalError* FindCriticalError(std::string_view code);  // nullptr when unknown

// One that was committed, or a limit that is borderline.
struct CriticalResult {
  std::string error;
  std::string name;  // metric
  double value = 0;
  std::string unit;
  double limit = 0;
  bool above = true;  // the limit is the most that passes; else the least
  // Standard, of the value, in `unit`; 0: the value has none, and is never borderline.
  double uncertainty = 0;
  std::string reason;  // "The contact with the next tooth is not broken (80.0 %, at most 25.0 %)."

  bool operator==(const CriticalResult&) const = default;
};

inline constexpr size_t kMaxCritical = 32;

struct FoundCritical {
  std::vector<CriticalResult> critical;
  // The value is so near the limit, on either side, that the measuring does not decide: no error, and a person's to
  // decide in graded work.
  std::vector<CriticalResult> borderline;
};
// Within kBorderlineWithin standard uncertainties. A value of 0 whose limit is 0 is none: nothing was found.
bool IsBorderline(double value, double limit, double uncertainty);
// Those of the rubric that the metrics show, in its order. What was not made, or is not in the task
// shows nothing. Errors: kInvalidInput when a metric is in neither list or not finite.
Result<FoundCritical> FindCritical(const scene::Rubric& rubric, const MetricSet& metrics);

// Errors: kInvalidInput naming "critical[1].metric" where the exercise does not ask for what it
// measures: the error could never be found. `metrics`: of any attempt at the exercise.
Status CheckCriticalIsMeasured(const scene::Rubric& rubric, const MetricSet& metrics);

}  // namespace enamel::scoring
