#include <boost/json.hpp>
#include <charconv>
#include <optional>
#include <utility>

#include "common/scoring/score.h"

// The stored form of a score: schemas/score.md.
namespace enamel::scoring {
namespace {

namespace json = boost::json;

constexpr double kMPerMm = 1e-3, kM3PerMm3 = 1e-9;

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
  void Read(const char* name, std::vector<double>& out, size_t max_size) {
    const json::array* list = Array(name, max_size);
    for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
      if (!(*list)[i].is_number()) return Fail(Path(name), "numbers");
      out.push_back(Rounded((*list)[i].to_number<double>()));
    }
  }
  void Read(const char* name, std::vector<std::string>& out, size_t max_size) {
    const json::array* list = Array(name, max_size);
    for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
      if (!(*list)[i].is_string()) return Fail(Path(name), "texts");
      out.emplace_back((*list)[i].get_string());
    }
  }
  bool Has(const char* name) const { return object_ && object_->contains(name); }
  const json::value* Member(const char* name) {
    if (!object_ || !status_.ok()) return nullptr;
    const json::value* v = object_->if_contains(name);
    if (!v) Fail(Path(name), "a member of this name");
    return v;
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
  void Fail(const std::string& path, const std::string& expected) {
    if (status_.ok()) {
      status_ = Status(Code::kInvalidInput, "score, " + path + ": expected " + expected, path);
    }
  }
  const json::object* object_;
  std::string path_;
  Status& status_;
};

constexpr std::pair<NoValue, std::string_view> kWhy[] = {{NoValue::kNotInTask, "not_in_task"},
                                                         {NoValue::kNotMade, "not_made"},
                                                         {NoValue::kNotUsed, "not_used"}};
std::string_view NameOf(NoValue why) {
  for (const auto& [value, name] : kWhy) {
    if (value == why) return name;
  }
  return {};
}
std::optional<NoValue> WhyOf(std::string_view name) {
  for (const auto& [value, known] : kWhy) {
    if (known == name) return value;
  }
  return std::nullopt;
}

void ReadReasons(ObjectReader& reader, Status& status, const std::string& at,
                 std::vector<Reason>& out, std::string& comment) {
  const json::array* list = reader.Array("reasons", kMaxReasons);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    ObjectReader item((*list)[i], at + ".reasons[" + std::to_string(i) + "]", status);
    Reason& reason = out.emplace_back();
    item.Read("code", reason.code);
    item.Read("values", reason.values, kMaxReasonValues);
    item.Read("units", reason.units, kMaxReasonValues);
  }
  reader.Read("comment", comment);
}

void ReadGates(ObjectReader& reader, Status& status, ScoreResult& out) {
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
    ReadReasons(item, status, "gates[" + std::to_string(i) + "]", g.reasons, g.comment);
  }
}

void ReadMissing(ObjectReader& reader, Status& status, ScoreResult& out) {
  const json::array* list = reader.Array("missing", 1024);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    const std::string at = "missing[" + std::to_string(i) + "]";
    ObjectReader item((*list)[i], at, status);
    MissingMetric& m = out.missing.emplace_back();
    std::string why;
    item.Read("name", m.name);
    item.Read("why", why);
    const std::optional<NoValue> known = WhyOf(why);
    m.why = known.value_or(NoValue::kNotUsed);
    if (status.ok() && !known) {
      status = Status(Code::kInvalidInput,
                      "score, " + at +
                          ".why: expected not_in_task, not_made or not_used, found \"" + why + "\"",
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
    item.Read("lasts_s", stroke.lasts_s);
    item.Read("volume_mm3", stroke.volume_m3);
    stroke.volume_m3 *= kM3PerMm3;
  }
}

void ReadEnvelope(ObjectReader& reader, Status& status, ScoreResult& out) {
  const json::value* value = reader.Member("envelope");
  if (value == nullptr || value->is_null()) return;
  Envelope& e = out.envelope.emplace();
  ObjectReader in(*value, "envelope", status);
  if (const json::array* list = in.Array("references", kMaxEnvelopeMembers)) {
    for (size_t i = 0; i < list->size(); ++i) {
      ObjectReader item((*list)[i], "envelope.references[" + std::to_string(i) + "]", status);
      EnvelopeOverlap& m = e.members.emplace_back();
      item.Read("attempt", m.attempt);
      item.Read("overlap_percent", m.dice);
      m.dice /= 100;
    }
  }
  for (auto [name, into] :
       {std::pair{"left_of_all_mm3", &e.left_of_all_m3}, {"disputed_mm3", &e.disputed_m3}}) {
    in.Read(name, *into);
    *into *= kM3PerMm3;
  }
  in.Read("taken_by_mm3", e.taken_by_m3, kMaxEnvelopeMembers + 1);
  for (double& volume : e.taken_by_m3) volume *= kM3PerMm3;
  const json::array* list = in.Array("metrics", 1024);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    ObjectReader item((*list)[i], "envelope.metrics[" + std::to_string(i) + "]", status);
    MetricPlace& p = e.metrics.emplace_back();
    item.Read("name", p.name);
    item.Read("unit", p.unit);
    item.Read("least", p.least);
    item.Read("median", p.median);
    item.Read("most", p.most);
    item.Read("spread", p.spread);
    item.Read("percentile", p.percentile);
    if (const json::value* z = item.Member("z"); z != nullptr && !z->is_null()) {
      item.Read("z", p.z.emplace());
    }
  }
}

void ReadDeductions(ObjectReader& reader, Status& status, ScoreResult& out) {
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
    item.Read("here", d.here);
    item.ReadInteger("half_tick", d.half_tick);
    item.Read("half_s", d.half_s);
    item.Read("strokes_mm3", d.strokes_m3);
    d.strokes_m3 *= kM3PerMm3;
    ReadStrokes(item, status, at, d);
  }
}

json::array ReasonsJson(const std::vector<Reason>& reasons) {
  json::array out;
  for (const Reason& reason : reasons) {
    json::array values;
    for (double value : reason.values) values.push_back(Rounded(value));
    out.push_back({{"code", reason.code},
                   {"values", std::move(values)},
                   {"units", json::value_from(reason.units)}});
  }
  return out;
}

json::value EnvelopeJson(const std::optional<Envelope>& envelope) {
  if (!envelope) return nullptr;
  json::array members, taken_by, metrics;
  for (const EnvelopeOverlap& m : envelope->members) {
    members.push_back({{"attempt", m.attempt}, {"overlap_percent", Rounded(100 * m.dice)}});
  }
  for (double m3 : envelope->taken_by_m3) taken_by.push_back(Rounded(m3 / kM3PerMm3));
  for (const MetricPlace& p : envelope->metrics) {
    metrics.push_back({{"name", p.name},
                       {"unit", p.unit},
                       {"least", Rounded(p.least)},
                       {"median", Rounded(p.median)},
                       {"most", Rounded(p.most)},
                       {"spread", Rounded(p.spread)},
                       {"z", p.z ? json::value(Rounded(*p.z)) : json::value()},
                       {"percentile", Rounded(p.percentile)}});
  }
  return json::object{{"references", std::move(members)},
                      {"left_of_all_mm3", Rounded(envelope->left_of_all_m3 / kM3PerMm3)},
                      {"disputed_mm3", Rounded(envelope->disputed_m3 / kM3PerMm3)},
                      {"taken_by_mm3", std::move(taken_by)},
                      {"metrics", std::move(metrics)}};
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
                         {"lasts_s", Rounded(stroke.lasts_s)},
                         {"volume_mm3", Rounded(stroke.volume_m3 / kM3PerMm3)}});
    }
    out.push_back({{"criterion", d.criterion},
                   {"left", d.left},
                   {"volume_mm3", Rounded(d.volume_m3 / kM3PerMm3)},
                   {"position_mm", triple(d.position_m / kMPerMm)},
                   {"facing", triple(d.facing)},
                   {"first_tick", d.first_tick},
                   {"first_s", Rounded(d.first_s)},
                   {"here", d.here},
                   {"half_tick", d.half_tick},
                   {"half_s", Rounded(d.half_s)},
                   {"stroke_count", d.stroke_count},
                   {"strokes_mm3", Rounded(d.strokes_m3 / kM3PerMm3)},
                   {"strokes", std::move(strokes)}});
  }
  return out;
}

}  // namespace

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
                        {"judged", c.judged},
                        {"reasons", ReasonsJson(c.reasons)},
                        {"comment", c.comment}});
  }
  json::array gates;
  for (const GateResult& g : result.gates) {
    gates.push_back({{"name", g.name},
                     {"title", g.title},
                     {"value", Rounded(g.value)},
                     {"unit", g.unit},
                     {"share", Rounded(g.share)},
                     {"reason", g.reason},
                     {"reasons", ReasonsJson(g.reasons)},
                     {"comment", g.comment}});
  }
  json::array metrics;
  for (const MetricValue& m : result.metrics) {
    json::object metric{{"name", m.name}, {"value", Rounded(m.value)}, {"unit", m.unit}};
    if (m.limited) metric["limited"] = true;
    metrics.push_back(std::move(metric));
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
                   {"envelope", EnvelopeJson(result.envelope)},
                   {"reference_attempt", result.reference_attempt},
                   {"rubric_version", result.rubric_version},
                   {"scoring_version", result.scoring_version},
                   {"core_version", result.core_version},
                   {"ticks", result.ticks},
                   {"gap_ticks", result.gap_ticks},
                   {"late_ticks", result.late_ticks},
                   {"bounded_ticks", result.bounded_ticks},
                   {"disturbance",
                    {{"disturbed", result.disturbance.disturbed()},
                     {"late_percent", Rounded(result.disturbance.late_percent)},
                     {"gap_percent", Rounded(result.disturbance.gap_percent)},
                     {"limited_percent", Rounded(result.disturbance.limited_percent)}}},
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
  // A score has four levels; a deeper document is not a score.
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
      item.Read("judged", c.judged);
      ReadReasons(item, status, "criteria[" + std::to_string(i) + "]", c.reasons, c.comment);
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
      if (item.Has("limited")) item.Read("limited", m.limited);
    }
  }
  ReadMissing(reader, status, out);
  ReadDeductions(reader, status, out);
  ReadEnvelope(reader, status, out);
  reader.Read("reference_attempt", out.reference_attempt);
  reader.ReadInteger("rubric_version", out.rubric_version);
  reader.ReadInteger("scoring_version", out.scoring_version);
  reader.ReadInteger("core_version", out.core_version);
  reader.ReadInteger("ticks", out.ticks);
  reader.ReadInteger("gap_ticks", out.gap_ticks);
  reader.ReadInteger("late_ticks", out.late_ticks);
  reader.ReadInteger("bounded_ticks", out.bounded_ticks);
  if (const json::value* member = reader.Member("disturbance")) {
    ObjectReader item(*member, "disturbance", status);
    item.Read("late_percent", out.disturbance.late_percent);
    item.Read("gap_percent", out.disturbance.gap_percent);
    item.Read("limited_percent", out.disturbance.limited_percent);
  }
  reader.Read("witness_ok", out.witness_ok);
  reader.Read("witness_note", out.witness_note);
  if (!status.ok()) return status;
  return out;
}

}  // namespace enamel::scoring
