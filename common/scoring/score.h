#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/scene/types.h"
#include "common/scoring/board.h"
#include "common/scoring/critical.h"
#include "common/scoring/deductions.h"
#include "common/scoring/envelope.h"
#include "common/scoring/metrics.h"
#include "common/scoring/mistakes/mistakes.h"
#include "common/scoring/reasons.h"

// From metrics to points and sentences; the stored form is in schemas/score.md.
// Thread safety: functions, any thread. Deterministic.
namespace enamel::scoring {

// The points that a group of regions lost, or a figure of the hand.
struct CriterionResult {
  std::string name;  // NameOf(Group), or the metric
  Group group = Group::kHand;
  std::string title;
  double value = 0;  // the hand's, in `unit`; a group has none
  std::string unit;
  double lost = 0;  // points
  // The most that the hand's figure costs. For a group, the full marks of a person who marks it by hand; the group may
  // lose more.
  double most = 0;
  State state = State::kAcceptable;
  // False: the hand's figure has no value here, or the device was at its limit
  // (MetricValue::limited), so it costs nothing.
  bool judged = true;
  std::string reason;  // the hand's, in English: Sentence of `reasons` and `comment`
  std::vector<Reason> reasons = {};
  std::string comment = {};  // the rubric's, where much was lost (kWorthCommentShare)

  bool operator==(const CriterionResult&) const = default;
};

// How scores are measured and computed. Only scores of one version compare: a change that may move
// a score of the same recording, or change the words of a judgement, needs a new version.
inline constexpr int32_t kScoringVersion = 1;
// Points of a hundred. A smaller loss gets no comment and no advice.
inline constexpr double kWorthAdvice = 0.5;
// A comment describes a fault. It is shown where this share of the criterion's points was lost, or
// this many of a hundred.
inline constexpr double kWorthCommentShare = 0.25, kWorthCommentPoints = 5;

// Fewer points are not acceptable. Chosen.
inline constexpr double kAcceptablePoints = 50;
// `error` and `name` of that limit in ScoreResult::borderline.
inline constexpr std::string_view kPassLimit = "points";

// What an examiner says of the whole, beside the points. With remarks: something is to be changed. Not acceptable: a
// critical error, a region to redo, or fewer than kAcceptablePoints.
enum class Acceptance : uint8_t { kAcceptable, kWithRemarks, kNotAcceptable };

// A score is metrics + rubric version + reference + core version; recomputed bit-identically.
struct ScoreResult {
  double score = 0;            // 0..100
  bool critical_fail = false;  // by `critical`, or by a criterion's fails_above
  std::vector<CriticalResult> critical;
  // Limits that the measuring does not decide, where nothing else is critical; the last may be the pass limit, of
  // kPassLimit. Scored as not critical. In graded work a person decides before the score is released.
  std::vector<CriticalResult> borderline;
  std::vector<BoardRow> board;  // beside the points, of which it takes none
  double points = 0;            // the score as if no error were critical
  // Standard, of `points`: from what the grid does to the regions' measures, as if to all of them at once.
  double points_uncertainty = 0;
  Acceptance acceptance = Acceptance::kAcceptable;
  std::vector<CriterionResult> criteria;  // groups in their order, then the hand's
  std::vector<RegionMeasure> measures;    // of the acceptable cut that was the kindest
  std::vector<RegionCost> costs;          // of the measures, in their order
  std::vector<Mistake> mistakes;          // the dearest first
  // Points lost beyond a hundred, which a score of 0 does not show: `points` is 100 less the sum of what `criteria` lost,
  // plus this.
  double beyond = 0;
  std::vector<MetricValue> metrics;    // all that was measured, also what the rubric does not use
  std::vector<MissingMetric> missing;  // those without a value here
  std::vector<Deduction> deductions;   // by the caller (FindDeductions)
  // The attempt's place among several references; filled by the caller (PlaceInEnvelope).
  std::optional<Envelope> envelope;
  std::string reference_attempt;  // UUID text; empty: judged by the exercise's own target
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

inline constexpr size_t kMaxCriteria = 64;
// Of one region: a few motions and a patch or two.
inline constexpr size_t kMaxMistakes = 256, kMaxMeasures = 64;
inline constexpr size_t kMaxDeductions = 2 * kMaxMistakes;
inline constexpr size_t kMaxScoreJsonBytes = 1 << 20;

// A cut as an acceptable cut measures it, with its cost by the rubric's prices.
struct MeasuredCut {
  FaultVolumes faults;
  std::vector<RegionMeasure> measures;
  CutCost cost;
};
// Errors: those of CostOf.
Result<MeasuredCut> MeasureCut(const AcceptableCut& r, const cutting::Volume& attempt,
                               const scene::Rubric& rubric);
// The same with the mistakes that explain the cost.
struct JudgedCut {
  std::vector<RegionMeasure> measures;
  CutCost cost;
  FoundMistakes found;
};
// Errors: those of CostOf.
Result<JudgedCut> JudgeCut(const AcceptableCut& r, const cutting::Volume& attempt,
                           const scene::Rubric& rubric);

// Errors: kInvalidInput naming the member ("criteria[2].map") when the rubric names an unknown metric, one that the
// finished tooth shows, an unknown critical error or another unit, has an empty or unsorted map, a share outside 0..1, or
// more than kMaxCriteria criteria or kMaxCritical errors; and those of ValidatePrices and ValidateRestorations.
Status ValidateRubric(const scene::Rubric& rubric);

// The groups that have a price, in their order: what a person can mark on a tooth.
std::vector<Group> GroupsOf(const scene::Rubric& rubric);
std::string_view TitleOf(Group group);  // "Outline"
// Full marks of a group where a person marks by hand: a hundred, shared evenly.
double FullMarksOf(const scene::Rubric& rubric);

// The score: 100 less what the cut and the hand cost, at least 0, or 0 after a critical error. A criterion of the hand
// costs its points times 1 - share by the piecewise linear map, constant beyond its ends; nothing where it has no value,
// or is a force at the device's limit, unless the force that is known already costs all that it can. `mistakes` may be
// empty where only the points are asked for. Fills all but deductions, envelope, reference_attempt and what the replay
// tells. Errors: those of ValidateRubric and CostOf; kInvalidInput when a metric is in neither list or not finite.
Result<ScoreResult> ApplyRubric(const scene::Rubric& rubric, const MetricSet& metrics,
                                std::vector<RegionMeasure> measures,
                                std::vector<Mistake> mistakes = {});

// The law that a result breaks, in words; empty: none. Points lost by criteria, regions and mistakes sum to what the
// score lacks, to 1e-9 of each. A result that breaks one waits for a person.
std::string BrokenLaw(const ScoreResult& result);

// Canonical: members in a fixed order, numbers to 12 significant digits, so that equal scores have
// equal bytes and ToJson(ScoreFromJson(text)) == text for any text of ours. Requires: all finite.
std::string ToJson(const ScoreResult& result);
// Errors: kTooLarge beyond kMaxScoreJsonBytes; kInvalidInput naming the member that is missing or
// of another type. Unknown members are ignored: a newer server may have written more.
Result<ScoreResult> ScoreFromJson(std::string_view json);
// Criteria and mistakes alone, for lists of thousands of attempts. Errors: as ScoreFromJson.
Result<ScoreResult> PointsFromJson(std::string_view json);

}  // namespace enamel::scoring
