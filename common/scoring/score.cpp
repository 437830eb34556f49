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

constexpr double kMPerMm = 1e-3, kM3PerMm3 = 1e-9;
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

std::string Number(double value, std::string_view unit) {
  char text[64];
  // As fine as anybody acts on: 0.01 mm is a tenth of the finest band, a tenth of a degree
  // likewise.
  int digits = unit == "%" || unit == "s" || unit == "deg" ? 1 : 2;
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  std::string_view shown = unit == "mm2"   ? "mm²"
                           : unit == "mm3" ? "mm³"
                           : unit == "deg" ? "°"
                                           : unit;
  return std::string(text) + (unit == "deg" ? "" : " ") + std::string(shown);
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
  out.reason = criterion.title + ": there is nothing to measure yet.";
  if (!criterion.comment.empty()) out.reason += " " + criterion.comment;
  return out;
}

GateResult Open(const scene::RubricGate& gate, double value) {
  const MetricInfo& info = *FindMetric(gate.metric);
  GateResult out{gate.metric, gate.title, value, gate.unit, ShareAt(gate.map, value), ""};
  out.reason = gate.title + ": " + Found(info, value) + AskedText(info, AskedFor(gate.map)) + ".";
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
  std::optional<double> value;
  NoValue why = NoValue::kNotInTask;
};
Result<Looked> LookUp(const MetricSet& metrics, const std::string& name) {
  for (const MetricValue& m : metrics.values) {
    if (m.name != name) continue;
    if (!std::isfinite(m.value)) return NotMeasured(name, ", whose value is not finite");
    return Looked{m.value, {}};
  }
  for (const MissingMetric& m : metrics.missing) {
    if (m.name == name) return Looked{{}, m.why};
  }
  return NotMeasured(name, ", which was not measured");
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
  void Read(const char* name, dvec3& out) {
    const json::array* list = Array(name, 3);
    if (!list) return;
    for (size_t i = 0; i < 3; ++i) {
      if (i >= list->size() || !(*list)[i].is_number()) return Fail(Path(name), "three numbers");
      out[static_cast<int>(i)] = Rounded((*list)[i].to_number<double>());
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
  bool Has(const char* name) const { return object_ && object_->contains(name); }
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

constexpr std::string_view kNotInTask = "not_in_task", kNotMade = "not_made";
std::string_view NameOf(NoValue why) { return why == NoValue::kNotInTask ? kNotInTask : kNotMade; }

void ReadGates(ObjectReader& reader, Status& status, ScoreResult& out) {
  if (!reader.Has("gates")) return;
  const json::array* list = reader.Array("gates", kMaxGates);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    ObjectReader item((*list)[i], "gates[" + std::to_string(i) + "]", status);
    GateResult& g = out.gates.emplace_back();
    item.Read("name", g.name);
    item.Read("title", g.title);
    item.Read("value", g.value);
    item.Read("unit", g.unit);
    item.Read("share", g.share);
    item.Read("reason", g.reason);
  }
}

void ReadMissing(ObjectReader& reader, Status& status, ScoreResult& out) {
  if (!reader.Has("missing")) return;
  const json::array* list = reader.Array("missing", 1024);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    const std::string at = "missing[" + std::to_string(i) + "]";
    ObjectReader item((*list)[i], at, status);
    MissingMetric& m = out.missing.emplace_back();
    std::string why;
    item.Read("name", m.name);
    item.Read("why", why);
    m.why = why == kNotMade ? NoValue::kNotMade : NoValue::kNotInTask;
    if (status.ok() && why != kNotMade && why != kNotInTask) {
      status =
          Status(Code::kInvalidInput,
                 "score, " + at + ".why: expected not_in_task or not_made, found \"" + why + "\"",
                 at + ".why");
    }
  }
}

void ReadStrokes(ObjectReader& reader, Status& status, const std::string& at, Deduction& out) {
  const json::array* list = reader.Array("strokes", Deduction::kMaxStrokes);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    ObjectReader item((*list)[i], at + ".strokes[" + std::to_string(i) + "]", status);
    FaultStroke& stroke = out.strokes.emplace_back();
    item.ReadInteger("number", stroke.number);
    item.ReadInteger("first_tick", stroke.first_tick);
    item.Read("first_s", stroke.first_s);
    item.Read("volume_mm3", stroke.volume_m3);
    stroke.volume_m3 *= kM3PerMm3;
  }
}

void ReadDeductions(ObjectReader& reader, Status& status, ScoreResult& out) {
  if (!reader.Has("deductions")) return;
  const json::array* list = reader.Array("deductions", kMaxDeductions);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    const std::string at = "deductions[" + std::to_string(i) + "]";
    ObjectReader item((*list)[i], at, status);
    Deduction& d = out.deductions.emplace_back();
    item.Read("criterion", d.criterion);
    item.Read("left", d.left);
    item.Read("volume_mm3", d.volume_m3);
    d.volume_m3 *= kM3PerMm3;
    item.Read("position_mm", d.position_m);
    d.position_m *= kMPerMm;
    item.Read("facing", d.facing);
    item.ReadInteger("first_tick", d.first_tick);
    item.Read("first_s", d.first_s);
    item.ReadInteger("stroke_count", d.stroke_count);
    ReadStrokes(item, status, at, d);
  }
}

json::array DeductionsJson(const std::vector<Deduction>& deductions) {
  auto triple = [](const dvec3& v) {
    // Adding zero turns -0 into 0.
    return json::array{Rounded(v.x) + 0.0, Rounded(v.y) + 0.0, Rounded(v.z) + 0.0};
  };
  json::array out;
  for (const Deduction& d : deductions) {
    json::array strokes;
    for (const FaultStroke& stroke : d.strokes) {
      strokes.push_back({{"number", stroke.number},
                         {"first_tick", stroke.first_tick},
                         {"first_s", Rounded(stroke.first_s)},
                         {"volume_mm3", Rounded(stroke.volume_m3 / kM3PerMm3)}});
    }
    out.push_back({{"criterion", d.criterion},
                   {"left", d.left},
                   {"volume_mm3", Rounded(d.volume_m3 / kM3PerMm3)},
                   {"position_mm", triple(d.position_m / kMPerMm)},
                   {"facing", triple(d.facing)},
                   {"first_tick", d.first_tick},
                   {"first_s", Rounded(d.first_s)},
                   {"stroke_count", d.stroke_count},
                   {"strokes", std::move(strokes)}});
  }
  return out;
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
    out.gates.push_back(Open(gate, *found.value));
    open *= out.gates.back().share;
  }
  double points = 0, max_points = 0;
  for (const RubricCriterion& criterion : rubric.criteria) {
    ENAMEL_ASSIGN_OR_RETURN(const Looked found, LookUp(metrics, criterion.metric));
    out.criteria.push_back(found.value ? Judge(criterion, *found.value, out.critical_fail)
                                       : Unjudged(criterion, found.why));
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

std::string ToJson(const ScoreResult& result) {
  json::array criteria;
  for (const CriterionResult& c : result.criteria) {
    criteria.push_back({{"name", c.name},
                        {"title", c.title},
                        {"value", Rounded(c.value)},
                        {"unit", c.unit},
                        {"points", Rounded(c.points)},
                        {"max_points", Rounded(c.max_points)},
                        {"reason", c.reason},
                        {"judged", c.judged}});
  }
  json::array gates;
  for (const GateResult& g : result.gates) {
    gates.push_back({{"name", g.name},
                     {"title", g.title},
                     {"value", Rounded(g.value)},
                     {"unit", g.unit},
                     {"share", Rounded(g.share)},
                     {"reason", g.reason}});
  }
  json::array metrics;
  for (const MetricValue& m : result.metrics) {
    metrics.push_back({{"name", m.name}, {"value", Rounded(m.value)}, {"unit", m.unit}});
  }
  json::array missing;
  for (const MissingMetric& m : result.missing) {
    missing.push_back({{"name", m.name}, {"why", NameOf(m.why)}});
  }
  json::object out{{"score", Rounded(result.score)},
                   {"critical_fail", result.critical_fail},
                   {"criteria", std::move(criteria)},
                   {"gates", std::move(gates)},
                   {"metrics", std::move(metrics)},
                   {"missing", std::move(missing)},
                   {"deductions", DeductionsJson(result.deductions)},
                   {"reference_attempt", result.reference_attempt},
                   {"rubric_version", result.rubric_version},
                   {"scoring_version", result.scoring_version},
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
  // A score has four levels; what is deeper is none of ours.
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
      // Scores of before have every criterion judged.
      if (item.Has("judged")) item.Read("judged", c.judged);
    }
  }
  ReadGates(reader, status, out);
  if (const json::array* list = reader.Array("metrics", 1024)) {
    for (size_t i = 0; i < list->size(); ++i) {
      ObjectReader item((*list)[i], "metrics[" + std::to_string(i) + "]", status);
      MetricValue& m = out.metrics.emplace_back();
      item.Read("name", m.name);
      item.Read("value", m.value);
      item.Read("unit", m.unit);
    }
  }
  ReadMissing(reader, status, out);
  ReadDeductions(reader, status, out);
  reader.Read("reference_attempt", out.reference_attempt);
  reader.ReadInteger("rubric_version", out.rubric_version);
  // Scores of version 1 do not say so, nor have they gates.
  out.scoring_version = 1;
  if (reader.Has("scoring_version")) reader.ReadInteger("scoring_version", out.scoring_version);
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
