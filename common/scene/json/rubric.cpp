#include "common/scene/json/rubric.h"

#include <boost/json.hpp>

#include "common/scene/json/json.h"
#include "common/scene/json/kinds.h"
#include "common/scene/json/text.h"

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
