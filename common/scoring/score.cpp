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

// A criterion's points where all of the rubric's are a hundred.
double WeightOf(const Rubric& rubric, const RubricCriterion& criterion) {
  double all = 0;
  for (const RubricCriterion& c : rubric.criteria) all += c.points;
  return 100 * criterion.points / all;
}

bool Fails(const RubricCriterion& criterion, double value) {
  return criterion.fails_above && value > *criterion.fails_above;
}

// The points that a criterion or gate took, of its own and of a hundred.
struct Loss {
  double share, points;
};
// Before the gates: they say for themselves what they took.
Loss LossOf(const Rubric& rubric, const RubricCriterion& criterion, double value) {
  if (Fails(criterion, value)) return {1, 100};
  const double share = 1 - ShareAt(criterion.map, value);
  return {share, WeightOf(rubric, criterion) * share};
}
Loss LossOf(const GateResult& gate) { return {1 - gate.share, 100 * (1 - gate.share)}; }

bool IsWorthAdvice(const Loss& loss) { return loss.points >= kWorthAdvice; }
bool IsWorthAComment(const Loss& loss) {
  return IsWorthAdvice(loss) &&
         (loss.share >= kWorthCommentShare || loss.points >= kWorthCommentPoints);
}

void Write(CriterionResult& out) {
  out.reason = Sentence(out.title, *FindMetric(out.name), out.reasons, out.comment);
  if (out.under.empty()) return;
  out.reason +=
      " The same mistake lost points under \"" + out.under + "\" and is not counted twice.";
}
void Write(GateResult& out) {
  out.reason = Sentence(out.title, *FindMetric(out.name), out.reasons, out.comment);
}

// What the criterion is charged for, and under which other one the rest is. Never worse than the
// value, but where the value says less than there is (a turned wall's median).
struct Charged {
  double value;
  std::string under;
};
Charged ChargedOf(const Rubric& rubric, const RubricCriterion& criterion,
                  const MetricValue& found) {
  const double share = ShareAt(criterion.map, found.value);
  if (!found.charged || Fails(criterion, found.value)) return {found.value, ""};
  if (found.under.empty()) return {*found.charged, ""};
  // Where it makes no difference, nothing is said of it.
  if (!(ShareAt(criterion.map, *found.charged) > share)) return {found.value, ""};
  for (const std::string& under : found.under) {
    for (const RubricCriterion& c : rubric.criteria) {
      if (c.metric == under && c.points > 0) return {*found.charged, c.title};
    }
  }
  return {found.value, ""};
}

// `lean`: of LeanOf, which then is what the criterion is charged for.
CriterionResult Judge(const Rubric& rubric, const RubricCriterion& criterion,
                      const MetricValue& found, const std::optional<JudgedLean>& lean,
                      bool& critical_fail) {
  const MetricInfo& info = *FindMetric(criterion.metric);
  CriterionResult out{
      criterion.metric, criterion.title, found.value, criterion.unit, 0, criterion.points, ""};
  const Charged charged =
      lean ? Charged{lean->beyond_deg, ""} : ChargedOf(rubric, criterion, found);
  out.charged = charged.value;
  out.under = charged.under;
  if (Fails(criterion, found.value)) {
    critical_fail = true;
    out.reasons = {FailsReason(info, found.value, *criterion.fails_above)};
  } else {
    out.points = criterion.points * ShareAt(criterion.map, charged.value);
    // What was measured; more is charged only where the measure says less than there is.
    out.reasons = {
        lean ? FoundReason(info, lean->angle_deg, lean->map)
             : FoundReason(info, out.under.empty() ? charged.value : found.value, criterion.map)};
  }
  if (found.below_grid) out.reasons.push_back(BelowGridReason(info, *found.below_grid));
  if (IsWorthAComment(LossOf(rubric, criterion, charged.value))) out.comment = criterion.comment;
  Write(out);
  return out;
}

// A criterion whose metric has no value. Without the comment, which is about a fault that was made.
CriterionResult Unjudged(const RubricCriterion& criterion, NoValue why) {
  CriterionResult out{criterion.metric, criterion.title, 0, criterion.unit, 0, 0, "", false};
  // Not made: the points can be had and were not. Not in the task: they were never there, and count
  // for nobody.
  if (why != NoValue::kNotInTask) out.max_points = criterion.points;
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
  CriterionResult out{criterion.metric, criterion.title, value, criterion.unit, 0, 0, "", false};
  out.charged = value;
  out.reasons = {LimitReason(*FindMetric(criterion.metric), value)};
  Write(out);
  return out;
}

GateResult Open(const scene::RubricGate& gate, const MetricValue& found) {
  const double value = found.value;
  const MetricInfo& info = *FindMetric(gate.metric);
  GateResult out{gate.metric, gate.title, value, gate.unit, ShareAt(gate.map, value), ""};
  out.reasons = {FoundReason(info, value, gate.map)};
  if (found.below_grid) out.reasons.push_back(BelowGridReason(info, *found.below_grid));
  if (out.share < 1) out.reasons.push_back(KeepsReason(out.share));
  if (IsWorthAComment(LossOf(out))) out.comment = gate.comment;
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

std::vector<std::string> CostlyCriteria(const Rubric& given, const ScoreResult& result) {
  const Rubric rubric = WithTolerances(given);
  std::vector<std::string> out;
  auto add = [&](const std::string& name) {
    if (std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
  };
  for (size_t i = 0; i < rubric.criteria.size() && i < result.criteria.size(); ++i) {
    const RubricCriterion& asked = rubric.criteria[i];
    const CriterionResult& found = result.criteria[i];
    const bool lost =
        found.max_points > 0 && (!found.judged || ShareAt(asked.map, found.charged) < 1);
    if (lost || (found.judged && Fails(asked, found.value))) add(found.name);
  }
  for (const GateResult& gate : result.gates) {
    if (gate.share < 1) add(gate.name);
  }
  return out;
}

std::optional<size_t> CriterionBehind(const Rubric& rubric, const ScoreResult& result,
                                      size_t gate) {
  constexpr double kMost = 0.5;
  const GateResult& closed = result.gates[gate];
  const auto metric = std::ranges::find(result.metrics, closed.name, &MetricValue::name);
  if (metric == result.metrics.end() || !metric->charged) return {};
  if (1 - ShareAt(rubric.gates[gate].map, *metric->charged) > kMost * (1 - closed.share)) return {};
  for (const std::string& under : metric->under) {
    for (size_t i = 0; i < rubric.criteria.size() && i < result.criteria.size(); ++i) {
      const RubricCriterion& asked = rubric.criteria[i];
      const CriterionResult& found = result.criteria[i];
      if (asked.metric != under || !(asked.points > 0) || !found.judged) continue;
      if (RemedyOf(*FindMetric(under), found.charged, asked.map) != nullptr) return i;
    }
  }
  return {};
}

void Advise(const Rubric& given, std::vector<Deduction> deductions, ScoreResult& result) {
  const Rubric rubric = WithTolerances(given);
  // The words are given where they cost most, of equal costs at the first.
  struct Told {
    std::string words;
    Reason reason;
    double points;
    std::vector<Reason>* reasons;
  };
  std::vector<Told> all;
  auto advise = [&](auto& part, const std::string& metric, const Loss& loss, double value,
                    const std::vector<scene::RubricPoint>& map) {
    if (!IsWorthAdvice(loss)) return;
    const MetricInfo& info = *FindMetric(metric);
    std::optional<Reason> advice = Advice(info, value, map, deductions);
    if (!advice) return;
    Told told{Sentence("", info, {*advice}, ""), *advice, loss.points, &part.reasons};
    const auto same = std::ranges::find(all, told.words, &Told::words);
    if (same == all.end()) {
      all.push_back(std::move(told));
    } else if (told.points > same->points) {
      *same = std::move(told);
    }
  };
  for (size_t i = 0; i < rubric.gates.size() && i < result.gates.size(); ++i) {
    GateResult& gate = result.gates[i];
    if (const auto behind = CriterionBehind(rubric, result, i)) {
      const RubricCriterion& asked = rubric.criteria[*behind];
      advise(gate, asked.metric, LossOf(gate), result.criteria[*behind].charged, asked.map);
    } else {
      advise(gate, gate.name, LossOf(gate), gate.value, rubric.gates[i].map);
    }
  }
  for (size_t i = 0; i < rubric.criteria.size() && i < result.criteria.size(); ++i) {
    CriterionResult& found = result.criteria[i];
    if (!found.judged) continue;
    const RubricCriterion& asked = rubric.criteria[i];
    const Loss loss = LossOf(rubric, asked, found.charged);
    // By the wall's angle: a wall may be too upright for its material.
    const auto lean = LeanOf(rubric, asked, {result.metrics, result.missing, {}});
    if (lean.ok() && *lean) {
      advise(found, found.name, loss, (*lean)->angle_deg, (*lean)->map);
    } else {
      advise(found, found.name, loss, found.charged, asked.map);
    }
  }
  for (Told& told : all) told.reasons->push_back(std::move(told.reason));
  for (GateResult& gate : result.gates) Write(gate);
  for (CriterionResult& criterion : result.criteria) Write(criterion);
  result.deductions = std::move(deductions);
}

Status ValidateRubric(const Rubric& rubric) {
  if (rubric.criteria.empty() || rubric.criteria.size() > kMaxCriteria) {
    return Status(Code::kInvalidInput,
                  "rubric: expected 1 to " + std::to_string(kMaxCriteria) + " criteria, found " +
                      std::to_string(rubric.criteria.size()),
                  "criteria");
  }
  double total = 0;
  for (size_t i = 0; i < rubric.criteria.size(); ++i) {
    const std::string item = "criteria[" + std::to_string(i) + "]";
    ENAMEL_RETURN_IF_ERROR(ValidateCriterion(item, rubric.criteria[i]));
    total += rubric.criteria[i].points;
  }
  if (rubric.gates.size() > kMaxGates) {
    return Status(Code::kInvalidInput,
                  "rubric: expected at most " + std::to_string(kMaxGates) + " gates, found " +
                      std::to_string(rubric.gates.size()),
                  "gates");
  }
  for (size_t i = 0; i < rubric.gates.size(); ++i) {
    const std::string item = "gates[" + std::to_string(i) + "]";
    const scene::RubricGate& gate = rubric.gates[i];
    ENAMEL_RETURN_IF_ERROR(ValidateMetric(item, gate.metric, gate.unit));
    ENAMEL_RETURN_IF_ERROR(ValidateMap(item, gate.map));
  }
  ENAMEL_RETURN_IF_ERROR(ValidateCritical(rubric));
  for (size_t i = 0; i < rubric.restorations.size(); ++i) {
    const auto& criteria = rubric.restorations[i].criteria;
    for (size_t k = 0; k < criteria.size(); ++k) {
      ENAMEL_RETURN_IF_ERROR(
          ValidateMap("restorations[" + std::to_string(i) + "].criteria[" + std::to_string(k) + "]",
                      criteria[k].map));
    }
  }
  ENAMEL_RETURN_IF_ERROR(ValidateRestorations(rubric));
  // Or a score would be 0 of 0.
  if (!(total > 0)) {
    return Status(Code::kInvalidInput, "rubric: no criterion gives points, so there is no score",
                  "criteria");
  }
  return Status::Ok();
}

Result<ScoreResult> ApplyRubric(const Rubric& given, const MetricSet& metrics) {
  ENAMEL_RETURN_IF_ERROR(ValidateRubric(given));
  const Rubric rubric = WithTolerances(given);
  ScoreResult out;
  out.metrics = metrics.values;
  out.missing = metrics.missing;
  out.rubric_version = rubric.version;
  double open = 1;
  for (const scene::RubricGate& gate : rubric.gates) {
    ENAMEL_ASSIGN_OR_RETURN(const Looked found, LookUp(metrics, gate.metric));
    if (!found.value) return NotMeasured(gate.metric, " for a gate, which has no value here");
    out.gates.push_back(Open(gate, *found.value));
    open *= out.gates.back().share;
  }
  double points = 0, max_points = 0;
  for (const RubricCriterion& criterion : rubric.criteria) {
    ENAMEL_ASSIGN_OR_RETURN(const Looked found, LookUp(metrics, criterion.metric));
    if (!found.value) {
      out.criteria.push_back(Unjudged(criterion, found.why));
    } else if (IsHidden(criterion, *found.value)) {
      out.criteria.push_back(Hidden(criterion, found.value->value));
    } else {
      ENAMEL_ASSIGN_OR_RETURN(const auto lean, LeanOf(rubric, criterion, metrics));
      out.criteria.push_back(Judge(rubric, criterion, *found.value, lean, out.critical_fail));
    }
    CriterionResult& result = out.criteria.back();
    // After the reasons: they are about this criterion, a gate about the whole.
    result.points *= open;
    points += result.points;
    max_points += result.max_points;
  }
  if (!(max_points > 0)) {
    return Status(Code::kInvalidInput,
                  "rubric: no criterion with points can be judged in this exercise", "criteria");
  }
  // Of the criteria that can be judged, so that exercises with fewer walls have 100 points too.
  out.points = 100 * (points / max_points);
  ENAMEL_ASSIGN_OR_RETURN(out.critical, FindCritical(rubric, metrics));
  out.critical_fail = out.critical_fail || !out.critical.empty();
  out.score = out.critical_fail ? 0 : out.points;
  auto remarked = [](const auto& part) { return !part.comment.empty(); };
  if (out.critical_fail) {
    out.acceptance = Acceptance::kNotAcceptable;
  } else if (std::ranges::any_of(out.criteria, remarked) ||
             std::ranges::any_of(out.gates, remarked)) {
    out.acceptance = Acceptance::kWithRemarks;
  }
  return out;
}

}  // namespace enamel::scoring
