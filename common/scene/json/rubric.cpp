#include "common/scene/json/rubric.h"

#include <boost/json.hpp>

#include "common/scene/json/json.h"
#include "common/scene/json/kinds.h"
#include "common/scene/json/text.h"
#include "common/scene/restoration.h"

namespace enamel::scene {
namespace {

namespace json = boost::json;

json::array MapJson(const std::vector<RubricPoint>& map) {
  json::array out;
  for (const RubricPoint& p : map) out.push_back(json::array{p.value, p.share});
  return out;
}

json::object CriterionJson(const RubricCriterion& c) {
  json::object out{{"metric", c.metric}, {"title", c.title},      {"unit", c.unit},
                   {"points", c.points}, {"map", MapJson(c.map)}, {"comment", c.comment}};
  if (c.fails_above) out["fails_above"] = *c.fails_above;
  return out;
}

json::object CriticalJson(const RubricCritical& c) {
  return {{"error", c.error},
          {"metric", c.metric},
          {"unit", c.unit},
          {c.above ? "above" : "below", c.limit},
          {"source", c.source}};
}

RubricCritical ReadCritical(ObjectReader& item) {
  RubricCritical c;
  c.error = item.Name("error");
  c.metric = item.Name("metric");
  c.unit = item.Text("unit", 1, 16);
  c.above = !item.Has("below");
  c.limit = item.Number(c.above ? "above" : "below", -1e9, 1e9);
  c.source = item.Text("source", 1, 500);
  item.Finish();
  return c;
}

void ReadMap(ObjectReader& in, std::vector<RubricPoint>& map) {
  for (const auto& row : in.Rows("map", 2, 64)) {
    if (row[1] < 0 || row[1] > 1) in.Refuse("map", "shares from 0 to 1", std::to_string(row[1]));
    // Strictly: shares are interpolated between neighbours.
    if (!map.empty() && row[0] <= map.back().value) {
      in.Refuse("map", "values in ascending order",
                std::to_string(row[0]) + " after " + std::to_string(map.back().value));
    }
    map.push_back({row[0], row[1]});
  }
}

json::array RangeJson(const DivergenceRange& range) { return {range.from_deg, range.to_deg}; }

json::object ToleranceJson(const RestorationTolerance& t) {
  json::object out{{"restoration", RestorationName(t.restoration)}, {"source", t.source}};
  if (t.divergence) {
    out["divergence_deg"] = {{"mesiodistal", RangeJson(t.divergence->mesiodistal)},
                             {"buccolingual", RangeJson(t.divergence->buccolingual)}};
  }
  json::array criteria, critical;
  for (const auto& c : t.criteria)
    criteria.push_back({{"metric", c.metric}, {"map", MapJson(c.map)}});
  out["criteria"] = std::move(criteria);
  for (const auto& c : t.critical)
    critical.push_back({{"error", c.error}, {"metric", c.metric}, {"limit", c.limit}});
  if (!critical.empty()) out["critical"] = std::move(critical);
  return out;
}

Restoration ReadRestoration(ObjectReader& in) {
  const std::string name = in.Name("restoration");
  std::string known;
  for (const RestorationEntry& entry : kRestorations) {
    if (entry.name == name) return entry.restoration;
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  in.Refuse("restoration", "one of " + known, "\"" + name + "\"");
  return Restoration::kNone;
}

DivergenceRange ReadRange(ObjectReader& in, const char* name) {
  const auto rows = in.Ints(name, 2, -45, 45);
  if (rows[0] >= rows[1]) {
    in.Refuse(name, "the lesser angle first",
              std::to_string(rows[0]) + " and " + std::to_string(rows[1]));
  }
  return {static_cast<double>(rows[0]), static_cast<double>(rows[1])};
}

RestorationTolerance ReadTolerance(ObjectReader& item) {
  RestorationTolerance t;
  t.restoration = ReadRestoration(item);
  t.source = item.Text("source", 1, 500);
  if (item.Has("divergence_deg")) {
    ObjectReader pairs = item.Object("divergence_deg");
    t.divergence = {ReadRange(pairs, "mesiodistal"), ReadRange(pairs, "buccolingual")};
    pairs.Finish();
  }
  for (ObjectReader& c : item.Objects("criteria", 0, 64)) {
    RestorationTolerance::Map& map = t.criteria.emplace_back();
    map.metric = c.Name("metric");
    ReadMap(c, map.map);
    c.Finish();
  }
  if (item.Has("critical")) {
    for (ObjectReader& c : item.Objects("critical", 1, 32)) {
      t.critical.push_back({c.Name("error"), c.Name("metric"), c.Number("limit", -1e9, 1e9)});
      c.Finish();
    }
  }
  item.Finish();
  return t;
}

}  // namespace

boost::json::object RubricJson(const Rubric& r) {
  json::array criteria, gates;
  for (const RubricCriterion& c : r.criteria) criteria.push_back(CriterionJson(c));
  for (const RubricGate& g : r.gates) {
    gates.push_back({{"metric", g.metric},
                     {"title", g.title},
                     {"unit", g.unit},
                     {"map", MapJson(g.map)},
                     {"comment", g.comment}});
  }
  json::object out{{"name", r.name}, {"version", r.version}, {"criteria", std::move(criteria)}};
  if (!gates.empty()) out["gates"] = std::move(gates);
  json::array critical;
  for (const RubricCritical& c : r.critical) critical.push_back(CriticalJson(c));
  if (!critical.empty()) out["critical"] = std::move(critical);
  if (r.restoration != Restoration::kNone) out["restoration"] = RestorationName(r.restoration);
  json::array restorations;
  for (const RestorationTolerance& t : r.restorations) restorations.push_back(ToleranceJson(t));
  if (!restorations.empty()) out["restorations"] = std::move(restorations);
  return out;
}

Rubric ReadRubric(ObjectReader& rubric) {
  Rubric r;
  r.name = rubric.Name("name");
  r.version = static_cast<int32_t>(rubric.Int("version", 1, 1'000'000));
  for (ObjectReader& item : rubric.Objects("criteria", 1, 64)) {
    RubricCriterion c;
    c.metric = item.Name("metric");
    c.title = item.Text("title", 1, 200);
    c.unit = item.Text("unit", 1, 16);
    c.points = item.Number("points", 0, 1000);
    ReadMap(item, c.map);
    c.comment = item.Text("comment", 0, 1'000);
    if (item.Has("fails_above")) c.fails_above = item.Number("fails_above", -1e9, 1e9);
    item.Finish();
    r.criteria.push_back(std::move(c));
  }
  if (rubric.Has("gates")) {
    for (ObjectReader& item : rubric.Objects("gates", 1, 8)) {
      RubricGate g;
      g.metric = item.Name("metric");
      g.title = item.Text("title", 1, 200);
      g.unit = item.Text("unit", 1, 16);
      ReadMap(item, g.map);
      g.comment = item.Text("comment", 0, 1'000);
      item.Finish();
      r.gates.push_back(std::move(g));
    }
  }
  if (rubric.Has("critical")) {
    for (ObjectReader& item : rubric.Objects("critical", 1, 32)) {
      r.critical.push_back(ReadCritical(item));
    }
  }
  if (rubric.Has("restoration")) r.restoration = ReadRestoration(rubric);
  if (rubric.Has("restorations")) {
    for (ObjectReader& item : rubric.Objects("restorations", 1, kRestorations.size())) {
      r.restorations.push_back(ReadTolerance(item));
    }
  }
  return r;
}

std::string ToJson(const Rubric& rubric) {
  json::object out{{kRubricKind, kFormat}};
  for (auto& member : RubricJson(rubric)) out.insert(member);
  return CanonicalText(out);
}

Result<Rubric> RubricFromJson(std::string_view text) {
  Result<json::value> document = ParseBounded(text);
  if (!document.ok()) return document.status();
  Status status;
  ObjectReader in(*document, "", status);
  in.Format(kRubricKind);
  Rubric rubric = ReadRubric(in);
  in.Finish();
  if (!status.ok()) return status;
  return rubric;
}

}  // namespace enamel::scene
