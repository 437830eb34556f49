#include "common/scoring/score.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

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

// The values that earn the most points, as far as the map says.
struct Asked {
  double from, to;
};
// Open where the map ends on its best share: beyond it nothing more is asked.
Asked AskedFor(const std::vector<scene::RubricPoint>& map) {
  double best = 0;
  for (const auto& p : map) best = std::max(best, p.share);
  size_t first = 0, last = 0;
  while (map[first].share != best) ++first;
  for (size_t i = first; i < map.size() && map[i].share == best; ++i) last = i;
  return {first == 0 ? -kInfinite : map[first].value,
          last + 1 == map.size() ? kInfinite : map[last].value};
}

// As fine as anybody acts on: 0.01 mm, a tenth of a degree or of a second.
int UsualDigits(std::string_view unit) {
  if (unit == "count") return 0;
  return unit == "%" || unit == "s" || unit == "deg" ? 1 : 2;
}

std::string Digits(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

double AsShown(double value, int digits) {
  const std::string text = Digits(value, digits);
  double out = 0;
  std::from_chars(text.data(), text.data() + text.size(), out);
  return out;
}

std::string Number(double value, std::string_view unit, int digits) {
  std::string text = Digits(value, digits);
  if (unit == "count" || unit == "ratio") return text;
  std::string_view shown = unit == "mm2"   ? "mm²"
                           : unit == "mm3" ? "mm³"
                           : unit == "deg" ? "°"
                                           : unit;
  return text + (unit == "deg" ? "" : " ") + std::string(shown);
}
std::string Number(double value, std::string_view unit) {
  return Number(value, unit, UsualDigits(unit));
}

// So many that a limit is shown as it is, 0.025 mm and not 0.03, and that what misses it does not
// read like it.
int DigitsFor(double value, const Asked& asked, std::string_view unit) {
  constexpr int kMost = 4;
  int digits = UsualDigits(unit);
  for (double limit : {asked.from, asked.to}) {
    if (!std::isfinite(limit)) continue;
    while (digits < kMost && std::fabs(AsShown(limit, digits) - limit) > 1e-9) ++digits;
  }
  for (double limit : {asked.from, asked.to}) {
    if (!std::isfinite(limit) || (value >= asked.from && value <= asked.to)) continue;
    while (digits < kMost && Digits(std::fabs(value), digits) == Digits(std::fabs(limit), digits)) {
      ++digits;
    }
  }
  return digits;
}

std::string Found(const MetricInfo& info, double value, int digits) {
  if (info.above_zero.empty()) return Number(value, info.unit, digits);
  std::string size = Number(std::fabs(value), info.unit, digits);
  // Shown as 0.00: neither too deep nor short.
  if (std::fabs(value) < 0.005) return size + " off";
  return size + " " + std::string(value > 0 ? info.above_zero : info.below_zero);
}

std::string AskedText(const MetricInfo& info, const Asked& asked, int digits) {
  auto number = [&](double value) { return Number(value, info.unit, digits); };
  bool open_below = asked.from == -kInfinite, open_above = asked.to == kInfinite;
  if (open_below && open_above) return "";
  if (open_below) return " (at most " + number(asked.to) + " asked for)";
  if (open_above) return " (at least " + number(asked.from) + " asked for)";
  if (asked.from == asked.to) return " (" + number(asked.to) + " asked for)";
  if (asked.from == -asked.to) return " (within " + number(asked.to) + " asked for)";
  return " (from " + number(asked.from) + " to " + number(asked.to) + " asked for)";
}

// What was found, beside what was asked for.
struct Comparison {
  std::string found, asked;
};
Comparison Compare(const MetricInfo& info, double value,
                   const std::vector<scene::RubricPoint>& map) {
  const Asked asked = AskedFor(map);
  const int digits = DigitsFor(value, asked, info.unit);
  return {Found(info, value, digits), AskedText(info, asked, digits)};
}

CriterionResult Judge(const RubricCriterion& criterion, double value, bool& critical_fail) {
  const MetricInfo& info = *FindMetric(criterion.metric);
  double share = ShareAt(criterion.map, value);
  CriterionResult out{criterion.metric,         criterion.title,  value, criterion.unit,
                      criterion.points * share, criterion.points, ""};
  const Comparison text = Compare(info, value, criterion.map);
  out.reason = criterion.title + ": " + text.found;
  bool critical = criterion.fails_above && value > *criterion.fails_above;
  if (critical) {
    critical_fail = true;
    out.points = 0;
    out.reason +=
        " (more than " + Number(*criterion.fails_above, info.unit) + " fails the whole attempt).";
  } else {
    out.reason += text.asked + ".";
  }
  // Advice only where points were lost.
  if ((critical || share < 1) && !criterion.comment.empty()) out.reason += " " + criterion.comment;
  return out;
}

// A criterion whose metric has no value.
CriterionResult Unjudged(const RubricCriterion& criterion, NoValue why) {
  CriterionResult out{criterion.metric, criterion.title, 0, criterion.unit, 0, 0, "", false};
  if (why == NoValue::kNotInTask) {
    out.reason = criterion.title + ": not judged, as the reference has nothing of it.";
    return out;
  }
  // Not made: the points can be had and were not. Not in the task: they were never there, and count
  // for nobody.
  out.max_points = criterion.points;
  // Without the comment, which is about a fault that was made.
  out.reason = criterion.title + ": there is nothing to measure yet.";
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

// What the device could not render is not held against a hand, nor is it taken as light: the points
// are nobody's. What the hand did at least is known, and where that costs all it stays judged.
bool IsHidden(const RubricCriterion& criterion, const MetricValue& found) {
  if (!found.limited) return false;
  const bool at_least = FindMetric(found.name)->at_limit == MetricInfo::AtLimit::kAtLeast;
  return !(at_least && ShareAt(criterion.map, found.value) < 1 &&
           CannotGetWorse(criterion, found.value));
}

CriterionResult Hidden(const RubricCriterion& criterion, double value) {
  CriterionResult out{criterion.metric, criterion.title, value, criterion.unit, 0, 0, "", false};
  out.reason = criterion.title + ": not judged, as the device was at its limit in more than " +
               Number(kMostLimited_percent, "%") +
               " of the time with force (measured: " + Number(value, criterion.unit) + ").";
  return out;
}

GateResult Open(const scene::RubricGate& gate, double value) {
  const MetricInfo& info = *FindMetric(gate.metric);
  GateResult out{gate.metric, gate.title, value, gate.unit, ShareAt(gate.map, value), ""};
  const Comparison text = Compare(info, value, gate.map);
  out.reason = gate.title + ": " + text.found + text.asked + ".";
  if (out.share < 1) {
    out.reason += " Every criterion keeps " + Number(100 * out.share, "%") + " of its points.";
    if (!gate.comment.empty()) out.reason += " " + gate.comment;
  }
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
  return NotMeasured(name, ", which was not measured; only scoring the recording again tells");
}

}  // namespace

std::vector<std::string> CostlyCriteria(const Rubric& rubric, const ScoreResult& result) {
  std::vector<std::string> out;
  auto add = [&](const std::string& name) {
    if (std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
  };
  for (size_t i = 0; i < rubric.criteria.size() && i < result.criteria.size(); ++i) {
    const RubricCriterion& asked = rubric.criteria[i];
    const CriterionResult& found = result.criteria[i];
    const bool critical = asked.fails_above && found.value > *asked.fails_above;
    const bool lost =
        found.max_points > 0 && (!found.judged || ShareAt(asked.map, found.value) < 1);
    if (lost || (found.judged && critical)) add(found.name);
  }
  for (const GateResult& gate : result.gates) {
    if (gate.share < 1) add(gate.name);
  }
  return out;
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
  // Or a score would be 0 of 0.
  if (!(total > 0)) {
    return Status(Code::kInvalidInput, "rubric: no criterion gives points, so there is no score",
                  "criteria");
  }
  return Status::Ok();
}

Result<ScoreResult> ApplyRubric(const Rubric& rubric, const MetricSet& metrics) {
  ENAMEL_RETURN_IF_ERROR(ValidateRubric(rubric));
  ScoreResult out;
  out.metrics = metrics.values;
  out.missing = metrics.missing;
  out.rubric_version = rubric.version;
  double open = 1;
  for (const scene::RubricGate& gate : rubric.gates) {
    ENAMEL_ASSIGN_OR_RETURN(const Looked found, LookUp(metrics, gate.metric));
    if (!found.value) return NotMeasured(gate.metric, " for a gate, which has no value here");
    out.gates.push_back(Open(gate, found.value->value));
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
      out.criteria.push_back(Judge(criterion, found.value->value, out.critical_fail));
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
  // Of what can be judged, so that exercises with fewer walls have 100 points too.
  out.score = out.critical_fail ? 0 : 100 * (points / max_points);
  return out;
}

}  // namespace enamel::scoring
