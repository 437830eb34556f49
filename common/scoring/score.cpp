#include "common/scoring/score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/scoring/tolerances.h"

namespace enamel::scoring {
namespace {

using scene::Rubric;
using scene::RubricCriterion;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// `item`: "criteria[2]".
Status BadItem(const std::string& item, const char* member, const std::string& message) {
  std::string field = item + "." + member;
  return Status(Code::kInvalidInput, "rubric, " + field + ": " + message, field);
}

Status ValidateMap(const std::string& item, const std::vector<scene::RubricPoint>& map) {
  if (map.empty()) {
    return BadItem(item, "map", "expected at least one {value, share}, found none");
  }
  double last = -kInfinite;
  for (const auto& point : map) {
    if (!std::isfinite(point.value) || !(point.value > last)) {
      return BadItem(item, "map",
                     "expected values in rising order, found " + std::to_string(point.value) +
                         " after " + std::to_string(last));
    }
    if (!(point.share >= 0 && point.share <= 1)) {
      return BadItem(item, "map",
                     "expected shares from 0 to 1, found " + std::to_string(point.share));
    }
    last = point.value;
  }
  return Status::Ok();
}

Status ValidateMetric(const std::string& item, const std::string& metric, const std::string& unit) {
  const MetricInfo* info = FindMetric(metric);
  if (!info) return BadItem(item, "metric", "no metric is called \"" + metric + "\"");
  if (unit == info->unit) return Status::Ok();
  return BadItem(
      item, "unit",
      "expected \"" + std::string(info->unit) + "\" for " + metric + ", found \"" + unit + "\"");
}

Status ValidateCriterion(const std::string& item, const RubricCriterion& criterion) {
  ENAMEL_RETURN_IF_ERROR(ValidateMetric(item, criterion.metric, criterion.unit));
  if (IsSeenOnTheTooth(criterion.metric)) {
    return BadItem(item, "metric",
                   "expected a figure of the hand (force, time, way), found \"" + criterion.metric +
                       "\", which the finished tooth shows: prices judge the tooth");
  }
  if (!(criterion.points >= 0 && criterion.points <= 1e6)) {
    return BadItem(item, "points", "expected 0 or more, found " + std::to_string(criterion.points));
  }
  if (criterion.fails_above && !std::isfinite(*criterion.fails_above)) {
    return BadItem(item, "fails_above", "expected a finite number");
  }
  return ValidateMap(item, criterion.map);
}

Status ValidateCritical(const Rubric& rubric) {
  if (rubric.critical.size() > kMaxCritical) {
    return Status(Code::kInvalidInput,
                  "rubric: expected at most " + std::to_string(kMaxCritical) +
                      " critical errors, found " + std::to_string(rubric.critical.size()),
                  "critical");
  }
  for (size_t i = 0; i < rubric.critical.size(); ++i) {
    const scene::RubricCritical& c = rubric.critical[i];
    const std::string item = "critical[" + std::to_string(i) + "]";
    if (FindCriticalError(c.error) == nullptr) {
      return BadItem(
          item, "error",
          "no critical error is called \"" + c.error + "\": schemas/critical_errors.json has them");
    }
    ENAMEL_RETURN_IF_ERROR(ValidateMetric(item, c.metric, c.unit));
    if (!std::isfinite(c.limit)) return BadItem(item, "above", "expected a finite number");
  }
  return Status::Ok();
}

double ShareAt(const std::vector<scene::RubricPoint>& map, double value) {
  // Constant beyond both ends: a map says all there is to say about a value.
  if (value <= map.front().value) return map.front().share;
  for (size_t i = 1; i < map.size(); ++i) {
    if (value > map[i].value) continue;
    // Never 0 below: ValidateMap has made sure that values rise.
    double t = (value - map[i - 1].value) / (map[i].value - map[i - 1].value);
    return map[i - 1].share + t * (map[i].share - map[i - 1].share);
  }
  return map.back().share;
}

bool Fails(const RubricCriterion& criterion, double value) {
  return criterion.fails_above && value > *criterion.fails_above;
}

CriterionResult ResultOf(const RubricCriterion& criterion, double value) {
  CriterionResult out;
  out.name = criterion.metric;
  out.title = criterion.title;
  out.value = value;
  out.unit = criterion.unit;
  out.most = criterion.points;
  return out;
}

void Write(CriterionResult& out) {
  out.reason = Sentence(out.title, *FindMetric(out.name), out.reasons, out.comment);
}

CriterionResult Judge(const RubricCriterion& criterion, const MetricValue& found,
                      bool& critical_fail) {
  const MetricInfo& info = *FindMetric(criterion.metric);
  CriterionResult out = ResultOf(criterion, found.value);
  if (Fails(criterion, found.value)) {
    critical_fail = true;
    out.lost = criterion.points;
    out.reasons = {FailsReason(info, found.value, *criterion.fails_above)};
  } else {
    out.lost = criterion.points * (1 - ShareAt(criterion.map, found.value));
    out.reasons = {FoundReason(info, found.value, criterion.map)};
  }
  if (found.below_grid) out.reasons.push_back(BelowGridReason(info, *found.below_grid));
  if (out.lost >= kWorthAdvice) {
    out.state = State::kModify;
    if (const Remedy* remedy = RemedyOf(info, found.value, criterion.map))
      out.reasons.push_back({std::string(remedy->code), {}, {}});
    if (out.lost >= kWorthCommentShare * out.most || out.lost >= kWorthCommentPoints)
      out.comment = criterion.comment;
  }
  Write(out);
  return out;
}

// A criterion whose metric has no value.
CriterionResult Unjudged(const RubricCriterion& criterion, NoValue why) {
  CriterionResult out = ResultOf(criterion, 0);
  out.judged = false;
  out.reasons = {MissingReason(why)};
  Write(out);
  return out;
}

// No larger value would earn less, or fail more.
bool CannotGetWorse(const RubricCriterion& criterion, double value) {
  if (criterion.fails_above) return value > *criterion.fails_above;
  double least = ShareAt(criterion.map, value);
  for (const auto& point : criterion.map) {
    if (point.value > value && point.share < least) return false;
  }
  return true;
}

// A force that the device could not render is neither held against a hand nor taken as light: its
// points go to nobody. The hand's least force is known; where that alone costs all the points, it
// stays judged.
bool IsHidden(const RubricCriterion& criterion, const MetricValue& found) {
  if (!found.limited) return false;
  const bool at_least = FindMetric(found.name)->at_limit == MetricInfo::AtLimit::kAtLeast;
  return !(at_least && ShareAt(criterion.map, found.value) < 1 &&
           CannotGetWorse(criterion, found.value));
}

CriterionResult Hidden(const RubricCriterion& criterion, double value) {
  CriterionResult out = ResultOf(criterion, value);
  out.judged = false;
  out.reasons = {LimitReason(*FindMetric(criterion.metric), value)};
  Write(out);
  return out;
}

Status NotMeasured(const std::string& metric, const char* how) {
  return Status(Code::kInvalidInput, "the rubric asks for metric " + metric + how, metric);
}

// The metric's value, or why there is none.
struct Looked {
  std::optional<MetricValue> value;
  NoValue why = NoValue::kNotInTask;
};
Result<Looked> LookUp(const MetricSet& metrics, const std::string& name) {
  for (const MetricValue& m : metrics.values) {
    if (m.name != name) continue;
    if (!std::isfinite(m.value)) return NotMeasured(name, ", whose value is not finite");
    return Looked{m, {}};
  }
  for (const MissingMetric& m : metrics.missing) {
    if (m.name == name && m.why != NoValue::kNotUsed) return Looked{{}, m.why};
  }
  return NotMeasured(name, ", which was not measured; score the recording again");
}

}  // namespace

std::vector<Group> GroupsOf(const Rubric& rubric) {
  std::vector<Group> out;
  for (const Group group :
       {Group::kOutline, Group::kInternalForm, Group::kMargins, Group::kTissuePreserved}) {
    // What was not done is internal form, and costs without a price of its own.
    const bool costs = group == GroupOf(whole::kNotDone) ||
                       std::ranges::any_of(rubric.prices, [&](const scene::RubricPrice& p) {
                         return GroupOf(p.of) == group;
                       });
    if (costs) out.push_back(group);
  }
  return out;
}

std::string_view TitleOf(Group group) {
  switch (group) {
    case Group::kOutline:
      return "Outline";
    case Group::kInternalForm:
      return "Internal form";
    case Group::kMargins:
      return "Margins";
    case Group::kTissuePreserved:
      return "Tissue preserved";
    case Group::kHand:
      break;
  }
  return "Hand";
}

double FullMarksOf(const Rubric& rubric) {
  const size_t groups = GroupsOf(rubric).size();
  return groups > 0 ? 100.0 / static_cast<double>(groups) : 0;
}

Result<MeasuredCut> MeasureCut(const AcceptableCut& r, const cutting::Volume& attempt,
                               const Rubric& rubric) {
  MeasuredCut out{MeasureFaults(r, attempt), {}, {}};
  out.measures = MeasuresOf(r, out.faults);
  ENAMEL_ASSIGN_OR_RETURN(out.cost, CostOf(out.measures, WithTolerances(rubric).prices));
  return out;
}

Result<JudgedCut> JudgeCut(const AcceptableCut& r, const cutting::Volume& attempt,
                           const Rubric& rubric) {
  ENAMEL_ASSIGN_OR_RETURN(MeasuredCut cut, MeasureCut(r, attempt, rubric));
  FoundMistakes found = FindMistakes(r, cut.faults, cut.cost);
  return JudgedCut{std::move(cut.measures), std::move(cut.cost), std::move(found)};
}

Status ValidateRubric(const Rubric& rubric) {
  if (rubric.prices.empty()) {
    return Status(Code::kInvalidInput,
                  "rubric: expected prices, found none: nothing that is cut would cost points",
                  "prices");
  }
  ENAMEL_RETURN_IF_ERROR(ValidatePrices(rubric.prices, "prices"));
  if (rubric.criteria.size() > kMaxCriteria - kGroups) {
    return Status(Code::kInvalidInput,
                  "rubric: expected at most " + std::to_string(kMaxCriteria - kGroups) +
                      " criteria, found " + std::to_string(rubric.criteria.size()),
                  "criteria");
  }
  for (size_t i = 0; i < rubric.criteria.size(); ++i) {
    ENAMEL_RETURN_IF_ERROR(
        ValidateCriterion("criteria[" + std::to_string(i) + "]", rubric.criteria[i]));
  }
  ENAMEL_RETURN_IF_ERROR(ValidateCritical(rubric));
  return ValidateRestorations(rubric);
}

namespace {

// Groups, with what their regions cost.
std::vector<CriterionResult> GroupResults(const Rubric& rubric,
                                          std::span<const RegionMeasure> measures,
                                          const CutCost& cost) {
  std::vector<CriterionResult> out;
  const double most = FullMarksOf(rubric);
  for (const Group group : GroupsOf(rubric)) {
    CriterionResult& c = out.emplace_back();
    c.name = NameOf(group);
    c.group = group;
    c.title = TitleOf(group);
    c.most = most;
    for (size_t i = 0; i < measures.size(); ++i) {
      if (GroupOf(measures[i].kind) != group) continue;
      c.lost += cost.rows[i].lost;
      c.state = std::max(c.state, cost.rows[i].state);
    }
  }
  return out;
}

State WorstOf(const ScoreResult& score) {
  State worst = State::kAcceptable;
  for (const RegionCost& cost : score.costs) worst = std::max(worst, cost.state);
  return worst;
}

Acceptance AcceptanceOf(const ScoreResult& score) {
  const State worst = WorstOf(score);
  if (score.critical_fail || worst == State::kRedo || score.points < kAcceptablePoints)
    return Acceptance::kNotAcceptable;
  return worst == State::kModify ? Acceptance::kWithRemarks : Acceptance::kAcceptable;
}

// Where the points alone decide.
bool IsNearThePassLimit(const ScoreResult& score) {
  return !score.critical_fail && WorstOf(score) != State::kRedo &&
         IsBorderline(score.points, kAcceptablePoints, score.points_uncertainty);
}

}  // namespace

Result<ScoreResult> ApplyRubric(const Rubric& given, const MetricSet& metrics,
                                std::vector<RegionMeasure> measures,
                                std::vector<Mistake> mistakes) {
  ENAMEL_RETURN_IF_ERROR(ValidateRubric(given));
  const Rubric rubric = WithTolerances(given);
  ENAMEL_ASSIGN_OR_RETURN(CutCost cost, CostOf(measures, rubric.prices));
  ScoreResult out;
  out.metrics = metrics.values;
  out.missing = metrics.missing;
  out.rubric_version = rubric.version;
  out.criteria = GroupResults(rubric, measures, cost);
  double lost = cost.sum;
  for (const RubricCriterion& criterion : rubric.criteria) {
    ENAMEL_ASSIGN_OR_RETURN(const Looked found, LookUp(metrics, criterion.metric));
    if (!found.value) {
      out.criteria.push_back(Unjudged(criterion, found.why));
    } else if (IsHidden(criterion, *found.value)) {
      out.criteria.push_back(Hidden(criterion, found.value->value));
    } else {
      out.criteria.push_back(Judge(criterion, *found.value, out.critical_fail));
    }
    lost += out.criteria.back().lost;
  }
  out.measures = std::move(measures);
  out.costs = std::move(cost.rows);
  out.mistakes = std::move(mistakes);
  out.points = std::max(0.0, 100 - lost);
  out.beyond = std::max(0.0, lost - 100);
  ENAMEL_ASSIGN_OR_RETURN(FoundCritical found, FindCritical(rubric, metrics));
  out.board = BoardTable(rubric, found);
  out.critical = std::move(found.critical);
  out.critical_fail = out.critical_fail || !out.critical.empty();
  // Else another error decides.
  if (!out.critical_fail) out.borderline = std::move(found.borderline);
  out.score = out.critical_fail ? 0 : out.points;
  out.acceptance = AcceptanceOf(out);
  out.points_uncertainty = cost.uncertainty;
  if (IsNearThePassLimit(out)) {
    const std::string points(kPassLimit);
    out.borderline.push_back({points, points, out.points, "", kAcceptablePoints, false,
                              out.points_uncertainty, "The points are near the least that pass."});
  }
  return out;
}

std::string BrokenLaw(const ScoreResult& result) {
  constexpr double kRounding = 1e-9;
  auto apart = [](double a, double b) {
    return !(std::fabs(a - b) <= kRounding * std::max(1.0, std::fabs(a)));
  };
  double criteria = 0, hand = 0, regions = 0, mistakes = 0;
  for (const CriterionResult& c : result.criteria) {
    criteria += c.lost;
    if (c.group == Group::kHand) hand += c.lost;
  }
  for (const RegionCost& cost : result.costs) regions += cost.lost;
  for (const Mistake& m : result.mistakes) mistakes += m.points;
  if (apart(criteria, 100 - result.points + result.beyond))
    return "criteria do not sum to the points lost";
  if (apart(regions + hand, criteria)) return "regions do not sum to the points of their groups";
  if (apart(mistakes, regions)) return "mistakes do not sum to the points of the regions";
  return {};
}

}  // namespace enamel::scoring
