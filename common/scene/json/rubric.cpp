#include "common/scene/json/rubric.h"

#include <boost/json.hpp>

#include "common/scene/json/json.h"
#include "common/scene/json/kinds.h"
#include "common/scene/json/text.h"
#include "common/scene/price_kinds.h"
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

// One that is not known is read like a region: scoring::ValidatePrices refuses it by name.
const PriceKind& KindOf(std::string_view of) {
  const PriceKind* kind = FindPriceKind(of);
  return kind == nullptr ? kPriceKinds.front() : *kind;
}

json::array PricesJson(const std::vector<RubricPrice>& prices) {
  json::array out;
  for (const RubricPrice& p : prices) {
    json::object item{{"of", p.of}};
    const PriceKind& kind = KindOf(p.of);
    if (kind.over) item[kind.over] = p.over;
    if (kind.left) item[kind.left] = p.left;
    item["points"] = p.points;
    item["most"] = p.most;
    item["modify_points"] = p.modify_points;
    item["redo_points"] = p.redo_points;
    item["source"] = p.source;
    out.push_back(std::move(item));
  }
  return out;
}

std::vector<RubricPrice> ReadPrices(ObjectReader& in, size_t least) {
  std::vector<RubricPrice> out;
  for (ObjectReader& item : in.Objects("prices", least, 32)) {
    RubricPrice& p = out.emplace_back();
    p.of = item.Name("of");
    const PriceKind& kind = KindOf(p.of);
    if (kind.over) p.over = item.Number(kind.over, 0, 1000);
    if (kind.left) p.left = item.Number(kind.left, 0, 1000);
    p.points = item.Number("points", 0, 10'000);
    p.most = item.Number("most", 0, 10'000);
    p.modify_points = item.Number("modify_points", 0, 10'000);
    p.redo_points = item.Number("redo_points", 0, 10'000);
    p.source = item.Text("source", 1, 500);
    item.Finish();
  }
  return out;
}

json::object ToleranceJson(const RestorationTolerance& t) {
  json::object out{{"restoration", RestorationName(t.restoration)}, {"source", t.source}};
  json::array critical;
  if (!t.prices.empty()) out["prices"] = PricesJson(t.prices);
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

RestorationTolerance ReadTolerance(ObjectReader& item) {
  RestorationTolerance t;
  t.restoration = ReadRestoration(item);
  t.source = item.Text("source", 1, 500);
  if (item.Has("prices")) t.prices = ReadPrices(item, 1);
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
  json::array criteria;
  for (const RubricCriterion& c : r.criteria) criteria.push_back(CriterionJson(c));
  json::object out{{"name", r.name},
                   {"version", r.version},
                   {"prices", PricesJson(r.prices)},
                   {"criteria", std::move(criteria)}};
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
  r.prices = ReadPrices(rubric, 1);
  for (ObjectReader& item : rubric.Objects("criteria", 0, 64)) {
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
  ENAMEL_ASSIGN_OR_RETURN(json::value document, ParseBounded(text));
  Status status;
  ObjectReader in(document, "", status);
  in.Format(kRubricKind);
  Rubric rubric = ReadRubric(in);
  in.Finish();
  ENAMEL_RETURN_IF_ERROR(status);
  return rubric;
}

}  // namespace enamel::scene
