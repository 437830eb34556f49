#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "common/scoring/critical.h"
#include "common/scoring/deductions.h"
#include "common/scoring/envelope.h"
#include "common/scoring/metrics.h"
#include "common/scoring/reasons.h"

// From metrics to points and sentences; the stored form is in schemas/score.md.
// Thread safety: functions, any thread. Deterministic.
namespace enamel::scoring {

struct CriterionResult {
  std::string name;  // metric
  std::string title;
  double value = 0;
  std::string unit;
  double points = 0;
  double max_points = 0;
  std::string reason;  // for the student, in English: Sentence of `reasons` and `comment`
  // False: the exercise does not ask for it (NoValue::kNotInTask), so it has neither points nor a
  // value; or there is nothing to measure yet (kNotMade), so it has no value and no points; or the
  // device was at its limit (MetricValue::limited), so it has a value and no points to be had.
  bool judged = true;
  // The finding, then what to do.
  std::vector<Reason> reasons = {};
  std::string comment = {};  // the rubric's, where much was lost (kWorthCommentShare)
  // The value that points are for: `value`, but for what the criterion with the title `under` is
  // charged for already.
  double charged = 0;
  std::string under = {};

  bool operator==(const CriterionResult&) const = default;
};

// A factor of every criterion's points.
struct GateResult {
  std::string name;  // metric
  std::string title;
  double value = 0;
  std::string unit;
  double share = 1;
  std::string reason;
  std::vector<Reason> reasons = {};  // as a criterion's
  std::string comment = {};

  bool operator==(const GateResult&) const = default;
};

// How scores are measured and computed. Only scores of one version compare: a change that may move
// a score of the same recording, or change the words of a judgement, needs a new version.
inline constexpr int32_t kScoringVersion = 1;
// Points of a hundred. A smaller loss gets no comment and no advice.
inline constexpr double kWorthAdvice = 0.5;
// A comment describes a fault. It is shown where this share of the criterion's points was lost, or
// this many of a hundred.
inline constexpr double kWorthCommentShare = 0.25, kWorthCommentPoints = 5;

// What an examiner says of the whole, beside the points. With remarks: a criterion or a gate lost so
// much that its comment is shown. Not acceptable: a critical error.
enum class Acceptance : uint8_t { kAcceptable, kWithRemarks, kNotAcceptable };

// A score is metrics + rubric version + reference + core version; recomputed bit-identically.
struct ScoreResult {
  double score = 0;            // 0..100
  bool critical_fail = false;  // by `critical`, or by a criterion's fails_above
  std::vector<CriticalResult> critical;
  double points = 0;  // the score as if no error were critical
  Acceptance acceptance = Acceptance::kAcceptable;
  std::vector<CriterionResult> criteria;  // points after the gates
  std::vector<GateResult> gates;
  std::vector<MetricValue> metrics;    // all that was measured, also what the rubric does not use
  std::vector<MissingMetric> missing;  // those without a value here
  // Where and when the criteria lost points; by the caller (CostlyCriteria, FindDeductions,
  // Advise).
  std::vector<Deduction> deductions;
  // The attempt's place among several references; filled by the caller (PlaceInEnvelope).
  std::optional<Envelope> envelope;
  std::string reference_attempt;  // UUID text
  int32_t rubric_version = 1;
  int32_t scoring_version = kScoringVersion;
  uint32_t core_version = core::kCoreVersion;
  // From the replay: the station's part in the attempt.
  uint64_t ticks = 0, gap_ticks = 0, late_ticks = 0, bounded_ticks = 0, outages = 0;
  Disturbance disturbance;  // likewise, as shares
  bool witness_ok = false;
  std::string witness_note;  // where it broke, when it did

  bool operator==(const ScoreResult&) const = default;
};

inline constexpr size_t kMaxCriteria = 64, kMaxGates = 8;
inline constexpr size_t kMaxDeductions = 2 * (kMaxCriteria + kMaxGates);
inline constexpr size_t kMaxScoreJsonBytes = 1 << 20;

// Errors: kInvalidInput naming the criterion ("criteria[2].map") when the rubric names an unknown
// metric, critical error or another unit, has an empty or unsorted map, a share outside 0..1, no
// points at all, or more than kMaxCriteria criteria, kMaxGates gates or kMaxCritical errors; and
// those of ValidateRestorations (tolerances.h).
Status ValidateRubric(const scene::Rubric& rubric);

// Points by the piecewise linear map, the material's where the rubric names one (tolerances.h),
// constant beyond its ends; the score is the share of all points in percent, times every gate's
// share, or 0 after a critical error. A criterion whose metric is not in the task is left out of
// both sums, and so is one of a force at the device's limit, unless the force that is known already
// costs all that it can. Fills score, critical_fail, critical, points, acceptance, criteria, gates,
// metrics, missing and rubric_version; the caller fills the rest.
// Errors: those of ValidateRubric; kInvalidInput when a metric is in neither list or not finite, a
// gate's metric has no value, or no criterion with points is in the task.
Result<ScoreResult> ApplyRubric(const scene::Rubric& rubric, const MetricSet& metrics);

// The metrics that cost points: of criteria that earned less than their points before the gates or
// failed the attempt, and of gates with a share below 1; each once, in the rubric's order, gates
// last. `result`: ApplyRubric's with this rubric.
std::vector<std::string> CostlyCriteria(const scene::Rubric& rubric, const ScoreResult& result);

// A gate takes the value that was measured, whatever explains it. The criterion under which most of
// what closed `result.gates[gate]` is charged, which says better what to do; empty where there is
// none. `rubric`: WithTolerances (tolerances.h).
std::optional<size_t> CriterionBehind(const scene::Rubric& rubric, const ScoreResult& result,
                                      size_t gate);

// Takes the deductions into the result, and with them what to do into the reasons of the criteria
// and gates that lost at least kWorthAdvice points: the same words once, where most was lost.
// `result`: ApplyRubric's with this rubric.
void Advise(const scene::Rubric& rubric, std::vector<Deduction> deductions, ScoreResult& result);

// Canonical: members in a fixed order, numbers to 12 significant digits, so that equal scores have
// equal bytes and ToJson(ScoreFromJson(text)) == text for any text of ours. Requires: all finite.
std::string ToJson(const ScoreResult& result);
// Errors: kTooLarge beyond kMaxScoreJsonBytes; kInvalidInput naming the member that is missing or
// of another type. Unknown members are ignored: a newer server may have written more.
Result<ScoreResult> ScoreFromJson(std::string_view json);
// Criteria and gates alone, for lists of thousands of attempts. Errors: as ScoreFromJson.
Result<ScoreResult> PointsFromJson(std::string_view json);

}  // namespace enamel::scoring
