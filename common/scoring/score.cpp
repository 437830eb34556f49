#include "common/scoring/score.h"

#include <algorithm>
#include <boost/json.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

namespace enamel::scoring {
namespace {

namespace json = boost::json;
using scene::Rubric;
using scene::RubricCriterion;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

Status BadCriterion(size_t index, const char* member, const std::string& message) {
  std::string field = "criteria[" + std::to_string(index) + "]." + member;
  return Status(Code::kInvalidInput, "rubric, " + field + ": " + message, field);
}

Status ValidateMap(size_t index, const RubricCriterion& criterion) {
  if (criterion.map.empty()) {
    return BadCriterion(index, "map", "expected at least one {value, share}, found none");
  }
  double last = -kInfinite;
  for (const auto& point : criterion.map) {
    if (!std::isfinite(point.value) || !(point.value > last)) {
      return BadCriterion(index, "map",
                          "expected values in rising order, found " + std::to_string(point.value) +
                              " after " + std::to_string(last));
    }
    if (!(point.share >= 0 && point.share <= 1)) {
      return BadCriterion(index, "map",
                          "expected shares from 0 to 1, found " + std::to_string(point.share));
    }
    last = point.value;
  }
  return Status::Ok();
}

Status ValidateCriterion(size_t index, const RubricCriterion& criterion) {
  const MetricInfo* info = FindMetric(criterion.metric);
  if (!info) {
    return BadCriterion(index, "metric", "no metric is called \"" + criterion.metric + "\"");
  }
  if (criterion.unit != info->unit) {
    return BadCriterion(index, "unit",
                        "expected \"" + std::string(info->unit) + "\" for " + criterion.metric +
                            ", found \"" + criterion.unit + "\"");
  }
  if (!(criterion.points >= 0 && criterion.points <= 1e6)) {
    return BadCriterion(index, "points",
                        "expected 0 or more, found " + std::to_string(criterion.points));
  }
  if (criterion.fails_above && !std::isfinite(*criterion.fails_above)) {
    return BadCriterion(index, "fails_above", "expected a finite number");
  }
  return ValidateMap(index, criterion);
}

double ShareAt(const std::vector<scene::RubricPoint>& map, double value) {
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

std::string Number(double value, std::string_view unit) {
  char text[64];
  int digits = unit == "%" || unit == "s" ? 1 : 2;
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  std::string_view shown = unit == "mm2" ? "mm²" : unit == "mm3" ? "mm³" : unit;
  return std::string(text) + " " + std::string(shown);
}

std::string Found(const MetricInfo& info, double value) {
  if (info.above_zero.empty()) return Number(value, info.unit);
  std::string size = Number(std::fabs(value), info.unit);
  // Shown as 0.00: neither too deep nor short.
  if (std::fabs(value) < 0.005) return size + " off";
  return size + " " + std::string(value > 0 ? info.above_zero : info.below_zero);
}

std::string AskedText(const MetricInfo& info, const Asked& asked) {
  bool open_below = asked.from == -kInfinite, open_above = asked.to == kInfinite;
  if (open_below && open_above) return "";
  if (open_below) return " (at most " + Number(asked.to, info.unit) + " asked for)";
  if (open_above) return " (at least " + Number(asked.from, info.unit) + " asked for)";
  if (asked.from == asked.to) return " (" + Number(asked.to, info.unit) + " asked for)";
  if (asked.from == -asked.to) return " (within " + Number(asked.to, info.unit) + " asked for)";
  return " (from " + Number(asked.from, info.unit) + " to " + Number(asked.to, info.unit) +
         " asked for)";
}

CriterionResult Judge(const RubricCriterion& criterion, double value, bool& critical_fail) {
  const MetricInfo& info = *FindMetric(criterion.metric);
  double share = ShareAt(criterion.map, value);
  CriterionResult out{criterion.metric,         criterion.title,  value, criterion.unit,
                      criterion.points * share, criterion.points, ""};
  out.reason = criterion.title + ": " + Found(info, value);
  bool critical = criterion.fails_above && value > *criterion.fails_above;
  if (critical) {
    critical_fail = true;
    out.points = 0;
    out.reason +=
        " (more than " + Number(*criterion.fails_above, info.unit) + " fails the whole attempt).";
  } else {
    out.reason += AskedText(info, AskedFor(criterion.map)) + ".";
  }
  if ((critical || share < 1) && !criterion.comment.empty()) out.reason += " " + criterion.comment;
  return out;
}

// To 12 significant digits: more than any metric means, and few enough that every reader of decimal
// text gives back the same double.
double Rounded(double value) {
  char text[40];
  auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 12).ptr;
  double out = value;
  std::from_chars(text, end, out);
  return out;
}

// Reads members of one object; the first trouble is kept and everything after it is empty.
// Not the strict reader of common/scene: a score of a newer server may hold members that this
// program does not know (score.h).
class ObjectReader {
 public:
  ObjectReader(const json::value& value, std::string path, Status& status)
      : object_(value.if_object()), path_(std::move(path)), status_(status) {
    if (!object_) Fail(path_, "an object");
  }

  void Read(const char* name, std::string& out) {
    if (const json::value* v = Member(name)) {
      if (v->is_string())
        out = std::string(v->get_string());
      else
        Fail(Path(name), "text");
    }
  }
  void Read(const char* name, bool& out) {
    if (const json::value* v = Member(name)) {
      if (v->is_bool())
        out = v->get_bool();
      else
        Fail(Path(name), "true or false");
    }
  }
  void Read(const char* name, double& out) {
    if (const json::value* v = Member(name)) {
      if (v->is_number())
        // As it was written, also where the text has more digits: what is read is written again
        // alike.
        out = Rounded(v->to_number<double>());
      else
        Fail(Path(name), "a number");
    }
  }
  template <typename Integer>
  void ReadInteger(const char* name, Integer& out) {
    if (const json::value* v = Member(name)) {
      boost::system::error_code error;
      auto number = v->to_number<Integer>(error);
      if (error)
        Fail(Path(name), "a whole number in range");
      else
        out = number;
    }
  }
  const json::array* Array(const char* name, size_t max_size) {
    const json::value* v = Member(name);
    if (!v) return nullptr;
    if (const json::array* array = v->if_array(); array && array->size() <= max_size) return array;
    Fail(Path(name), "a list of at most " + std::to_string(max_size));
    return nullptr;
  }

 private:
  std::string Path(const char* name) const { return path_.empty() ? name : path_ + "." + name; }
  const json::value* Member(const char* name) {
    if (!object_ || !status_.ok()) return nullptr;
    const json::value* v = object_->if_contains(name);
    if (!v) Fail(Path(name), "a member of this name");
    return v;
  }
  void Fail(const std::string& path, const std::string& expected) {
    if (status_.ok()) {
      status_ = Status(Code::kInvalidInput, "score, " + path + ": expected " + expected, path);
    }
  }
  const json::object* object_;
  std::string path_;
  Status& status_;
};

}  // namespace

Status ValidateRubric(const Rubric& rubric) {
  if (rubric.criteria.empty() || rubric.criteria.size() > kMaxCriteria) {
    return Status(Code::kInvalidInput,
                  "rubric: expected 1 to " + std::to_string(kMaxCriteria) + " criteria, found " +
                      std::to_string(rubric.criteria.size()),
                  "criteria");
  }
  double total = 0;
  for (size_t i = 0; i < rubric.criteria.size(); ++i) {
    ENAMEL_RETURN_IF_ERROR(ValidateCriterion(i, rubric.criteria[i]));
    total += rubric.criteria[i].points;
  }
  // Or a score would be 0 of 0.
  if (!(total > 0)) {
    return Status(Code::kInvalidInput, "rubric: no criterion gives points, so there is no score",
                  "criteria");
  }
  return Status::Ok();
}

Result<ScoreResult> ApplyRubric(const Rubric& rubric, const std::vector<MetricValue>& metrics) {
  ENAMEL_RETURN_IF_ERROR(ValidateRubric(rubric));
  ScoreResult out;
  out.metrics = metrics;
  out.rubric_version = rubric.version;
  double points = 0, max_points = 0;
  for (const RubricCriterion& criterion : rubric.criteria) {
    auto metric = std::find_if(metrics.begin(), metrics.end(),
                               [&](const MetricValue& m) { return m.name == criterion.metric; });
    if (metric == metrics.end() || !std::isfinite(metric->value)) {
      return Status(Code::kInvalidInput,
                    "the rubric asks for metric " + criterion.metric +
                        (metric == metrics.end() ? ", which was not measured"
                                                 : ", whose value is not finite"),
                    criterion.metric);
    }
    out.criteria.push_back(Judge(criterion, metric->value, out.critical_fail));
    points += out.criteria.back().points;
    max_points += criterion.points;
  }
  out.score = out.critical_fail ? 0 : 100 * (points / max_points);
  return out;
}

std::string ToJson(const ScoreResult& result) {
  json::array criteria;
  for (const CriterionResult& c : result.criteria) {
    criteria.push_back({{"name", c.name},
                        {"title", c.title},
                        {"value", Rounded(c.value)},
                        {"unit", c.unit},
                        {"points", Rounded(c.points)},
                        {"max_points", Rounded(c.max_points)},
                        {"reason", c.reason}});
  }
  json::array metrics;
  for (const MetricValue& m : result.metrics) {
    metrics.push_back({{"name", m.name}, {"value", Rounded(m.value)}, {"unit", m.unit}});
  }
  json::object out{{"score", Rounded(result.score)},
                   {"critical_fail", result.critical_fail},
                   {"criteria", std::move(criteria)},
                   {"metrics", std::move(metrics)},
                   {"reference_attempt", result.reference_attempt},
                   {"rubric_version", result.rubric_version},
                   {"core_version", result.core_version},
                   {"ticks", result.ticks},
                   {"gap_ticks", result.gap_ticks},
                   {"late_ticks", result.late_ticks},
                   {"bounded_ticks", result.bounded_ticks},
                   {"witness_ok", result.witness_ok},
                   {"witness_note", result.witness_note}};
  return json::serialize(out);
}

Result<ScoreResult> ScoreFromJson(std::string_view text) {
  if (text.size() > kMaxScoreJsonBytes) {
    return Status(Code::kTooLarge, "score: expected at most " + std::to_string(kMaxScoreJsonBytes) +
                                       " bytes, found " + std::to_string(text.size()));
  }
  boost::system::error_code error;
  json::parse_options options;
  options.max_depth = 8;
  json::value value = json::parse(text, error, {}, options);
  if (error) return Status(Code::kInvalidInput, "score: not JSON: " + error.message());

  Status status;
  ScoreResult out;
  ObjectReader reader(value, "", status);
  reader.Read("score", out.score);
  reader.Read("critical_fail", out.critical_fail);
  if (const json::array* list = reader.Array("criteria", kMaxCriteria)) {
    for (size_t i = 0; i < list->size(); ++i) {
      ObjectReader item((*list)[i], "criteria[" + std::to_string(i) + "]", status);
      CriterionResult& c = out.criteria.emplace_back();
      item.Read("name", c.name);
      item.Read("title", c.title);
      item.Read("value", c.value);
      item.Read("unit", c.unit);
      item.Read("points", c.points);
      item.Read("max_points", c.max_points);
      item.Read("reason", c.reason);
    }
  }
  if (const json::array* list = reader.Array("metrics", 1024)) {
    for (size_t i = 0; i < list->size(); ++i) {
      ObjectReader item((*list)[i], "metrics[" + std::to_string(i) + "]", status);
      MetricValue& m = out.metrics.emplace_back();
      item.Read("name", m.name);
      item.Read("value", m.value);
      item.Read("unit", m.unit);
    }
  }
  reader.Read("reference_attempt", out.reference_attempt);
  reader.ReadInteger("rubric_version", out.rubric_version);
  reader.ReadInteger("core_version", out.core_version);
  reader.ReadInteger("ticks", out.ticks);
  reader.ReadInteger("gap_ticks", out.gap_ticks);
  reader.ReadInteger("late_ticks", out.late_ticks);
  reader.ReadInteger("bounded_ticks", out.bounded_ticks);
  reader.Read("witness_ok", out.witness_ok);
  reader.Read("witness_note", out.witness_note);
  if (!status.ok()) return status;
  return out;
}

}  // namespace enamel::scoring
