#include <boost/json.hpp>
#include <optional>

#include "common/scoring/score_json.h"

// Reads the stored form of a score: schemas/score.md.
namespace enamel::scoring {
namespace {

namespace json = boost::json;
using namespace stored;

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
  // One of the names.
  template <typename T, size_t kCount>
  void ReadName(const char* name, const Name<T> (&names)[kCount], T& out) {
    std::string text;
    Read(name, text);
    if (!status_.ok()) return;
    if (const auto* known = std::ranges::find(names, text, &Name<T>::second);
        known != std::end(names)) {
      out = known->first;
      return;
    }
    std::string all;
    for (const Name<T>& n : names) all += (all.empty() ? "" : ", ") + std::string(n.second);
    Fail(Path(name), "one of " + all + ", found \"" + text + "\"");
  }
  // One of the first `count` values of T, by NameOf.
  template <typename T>
  void ReadEnum(const char* name, size_t count, T& out) {
    std::string text, all;
    Read(name, text);
    if (!status_.ok()) return;
    for (size_t i = 0; i < count; ++i) {
      const std::string_view known = scoring::NameOf(static_cast<T>(i));
      if (known == text) {
        out = static_cast<T>(i);
        return;
      }
      all += (i == 0 ? "" : ", ") + std::string(known);
    }
    Fail(Path(name), "one of " + all + ", found \"" + text + "\"");
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

void ReadCriteria(ObjectReader& reader, Status& status, ScoreResult& out) {
  const json::array* list = reader.Array("criteria", kMaxCriteria);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    ObjectReader item((*list)[i], "criteria[" + std::to_string(i) + "]", status);
    CriterionResult& c = out.criteria.emplace_back();
    item.Read("name", c.name);
    item.Read("title", c.title);
    item.Read("value", c.value);
    item.Read("unit", c.unit);
    item.Read("lost", c.lost);
    item.Read("most", c.most);
    item.ReadEnum("group", kGroups, c.group);
    item.ReadEnum("state", kStates, c.state);
    item.Read("reason", c.reason);
    item.Read("judged", c.judged);
    ReadReasons(item, status, "criteria[" + std::to_string(i) + "]", c.reasons, c.comment);
  }
}

void ReadRegions(ObjectReader& reader, Status& status, ScoreResult& out) {
  const json::array* list = reader.Array("regions", kMaxMeasures);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    ObjectReader item((*list)[i], "regions[" + std::to_string(i) + "]", status);
    RegionMeasure& m = out.measures.emplace_back();
    RegionCost& cost = out.costs.emplace_back();
    item.Read("name", m.name);
    item.Read("kind", m.kind);
    item.Read("over", m.over);
    item.Read("left", m.left);
    item.Read("uncertainty", m.uncertainty);
    item.ReadName("dearer", kSides, cost.over);
    item.Read("lost", cost.lost);
    item.ReadEnum("state", kStates, cost.state);
  }
}

void ReadMistakes(ObjectReader& reader, Status& status, ScoreResult& out) {
  const json::array* list = reader.Array("mistakes", kMaxMistakes);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    ObjectReader item((*list)[i], "mistakes[" + std::to_string(i) + "]", status);
    Mistake& m = out.mistakes.emplace_back();
    item.ReadEnum("kind", kMistakeKinds, m.kind);
    item.Read("place", m.place);
    item.Read("size", m.size);
    item.Read("points", m.points);
    item.ReadEnum("group", kGroups, m.group);
    item.Read("at_mm", m.at_m);
    m.at_m *= kMPerMm;
    item.Read("towards", m.towards);
  }
}

void ReadMissing(ObjectReader& reader, Status& status, ScoreResult& out) {
  const json::array* list = reader.Array("missing", 1024);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    const std::string at = "missing[" + std::to_string(i) + "]";
    ObjectReader item((*list)[i], at, status);
    MissingMetric& m = out.missing.emplace_back();
    item.Read("name", m.name);
    item.ReadName("why", kWhy, m.why);
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
    item.ReadInteger("mistake", d.mistake);
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

void ReadCritical(ObjectReader& reader, Status& status, const char* name,
                  std::vector<CriticalResult>& out) {
  // The pass limit may be beside those of the rubric.
  const json::array* list = reader.Array(name, kMaxCritical + 1);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    ObjectReader item((*list)[i], std::string(name) + "[" + std::to_string(i) + "]", status);
    CriticalResult& c = out.emplace_back();
    item.Read("error", c.error);
    item.Read("name", c.name);
    item.Read("value", c.value);
    item.Read("unit", c.unit);
    item.Read("limit", c.limit);
    item.Read("above", c.above);
    item.Read("uncertainty", c.uncertainty);
    item.Read("reason", c.reason);
  }
}

void ReadBoard(ObjectReader& reader, Status& status, ScoreResult& out) {
  const json::array* list = reader.Array("board", kGroups);
  for (size_t i = 0; list != nullptr && i < list->size(); ++i) {
    ObjectReader item((*list)[i], "board[" + std::to_string(i) + "]", status);
    BoardRow& row = out.board.emplace_back();
    item.ReadEnum("category", kGroups, row.category);
    if (const json::value* grade = item.Member("grade"); grade != nullptr && !grade->is_null())
      item.ReadEnum("grade", kBoardGrades, row.grade.emplace());
    item.Read("borderline", row.borderline);
    item.Read("error", row.error);
    item.Read("source", row.source);
  }
}

Result<json::value> DocumentOf(std::string_view text, json::storage_ptr memory) {
  if (text.size() > kMaxScoreJsonBytes) {
    return Status(Code::kTooLarge, "score: expected at most " + std::to_string(kMaxScoreJsonBytes) +
                                       " bytes, found " + std::to_string(text.size()));
  }
  boost::system::error_code error;
  json::parse_options options;
  // A score has four levels; a deeper document is not a score.
  options.max_depth = 8;
  json::value value = json::parse(text, error, std::move(memory), options);
  if (error) return Status(Code::kInvalidInput, "score: not JSON: " + error.message());
  return value;
}

}  // namespace

Result<ScoreResult> PointsFromJson(std::string_view text) {
  json::monotonic_resource memory(2 * text.size());
  ENAMEL_ASSIGN_OR_RETURN(const json::value value, DocumentOf(text, &memory));
  Status status;
  ScoreResult out;
  ObjectReader reader(value, "", status);
  ReadCriteria(reader, status, out);
  ReadMistakes(reader, status, out);
  if (!status.ok()) return status;
  return out;
}

Result<ScoreResult> ScoreFromJson(std::string_view text) {
  ENAMEL_ASSIGN_OR_RETURN(const json::value value, DocumentOf(text, {}));
  Status status;
  ScoreResult out;
  ObjectReader reader(value, "", status);
  reader.Read("score", out.score);
  reader.Read("critical_fail", out.critical_fail);
  ReadCritical(reader, status, "critical", out.critical);
  ReadCritical(reader, status, "borderline", out.borderline);
  ReadBoard(reader, status, out);
  reader.Read("points", out.points);
  reader.Read("points_uncertainty", out.points_uncertainty);
  reader.ReadName("acceptance", kAcceptances, out.acceptance);
  ReadCriteria(reader, status, out);
  ReadRegions(reader, status, out);
  ReadMistakes(reader, status, out);
  reader.Read("beyond", out.beyond);
  if (const json::array* list = reader.Array("metrics", 1024)) {
    for (size_t i = 0; i < list->size(); ++i) {
      ObjectReader item((*list)[i], "metrics[" + std::to_string(i) + "]", status);
      MetricValue& m = out.metrics.emplace_back();
      item.Read("name", m.name);
      item.Read("value", m.value);
      item.Read("unit", m.unit);
      if (item.Has("limited")) item.Read("limited", m.limited);
      if (item.Has("below_grid")) item.Read("below_grid", m.below_grid.emplace());
      if (item.Has("uncertainty")) item.Read("uncertainty", m.uncertainty.emplace());
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
  reader.ReadInteger("outages", out.outages);
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
