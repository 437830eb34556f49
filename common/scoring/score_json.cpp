#include "common/scoring/score_json.h"

#include <boost/json.hpp>

// Writes the stored form of a score: schemas/score.md.
namespace enamel::scoring {
namespace {

namespace json = boost::json;
using namespace stored;

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

json::array Triple(const dvec3& v) {
  // Adding zero turns -0 into 0.
  return {Rounded(v.x) + 0.0, Rounded(v.y) + 0.0, Rounded(v.z) + 0.0};
}

json::array CriteriaJson(const std::vector<CriterionResult>& criteria) {
  json::array out;
  for (const CriterionResult& c : criteria) {
    out.push_back({{"name", c.name},
                   {"group", scoring::NameOf(c.group)},
                   {"title", c.title},
                   {"value", Rounded(c.value)},
                   {"unit", c.unit},
                   {"lost", Rounded(c.lost)},
                   {"most", Rounded(c.most)},
                   {"state", scoring::NameOf(c.state)},
                   {"judged", c.judged},
                   {"reason", c.reason},
                   {"reasons", ReasonsJson(c.reasons)},
                   {"comment", c.comment}});
  }
  return out;
}

json::array RegionsJson(const ScoreResult& score) {
  json::array out;
  for (size_t i = 0; i < score.measures.size(); ++i) {
    const RegionMeasure& m = score.measures[i];
    const RegionCost& cost = score.costs[i];
    out.push_back({{"name", m.name},
                   {"kind", m.kind},
                   {"group", scoring::NameOf(GroupOf(m.kind))},
                   {"over", Rounded(m.over)},
                   {"left", Rounded(m.left)},
                   {"unit", UnitOf(m.kind)},
                   {"uncertainty", Rounded(m.uncertainty)},
                   {"dearer", stored::NameOf(kSides, cost.over)},
                   {"lost", Rounded(cost.lost)},
                   {"state", scoring::NameOf(cost.state)}});
  }
  return out;
}

json::array MistakesJson(const std::vector<Mistake>& mistakes) {
  json::array out;
  for (const Mistake& m : mistakes) {
    out.push_back({{"kind", scoring::NameOf(m.kind)},
                   {"place", m.place},
                   {"size", Rounded(m.size)},
                   {"unit", UnitOf(m.kind)},
                   {"points", Rounded(m.points)},
                   {"group", scoring::NameOf(m.group)},
                   {"at_mm", Triple(m.at_m / kMPerMm)},
                   {"towards", Triple(m.towards)}});
  }
  return out;
}

json::array DeductionsJson(const std::vector<Deduction>& deductions) {
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
    out.push_back({{"mistake", d.mistake},
                   {"left", d.left},
                   {"volume_mm3", Rounded(d.volume_m3 / kM3PerMm3)},
                   {"position_mm", Triple(d.position_m / kMPerMm)},
                   {"facing", Triple(d.facing)},
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

json::array CriticalJson(const std::vector<CriticalResult>& critical) {
  json::array out;
  for (const CriticalResult& c : critical) {
    out.push_back({{"error", c.error},
                   {"name", c.name},
                   {"value", Rounded(c.value)},
                   {"unit", c.unit},
                   {"limit", Rounded(c.limit)},
                   {"above", c.above},
                   {"uncertainty", Rounded(c.uncertainty)},
                   {"reason", c.reason}});
  }
  return out;
}

json::array BoardJson(const std::vector<BoardRow>& board) {
  json::array out;
  for (const BoardRow& row : board) {
    out.push_back({{"category", scoring::NameOf(row.category)},
                   {"grade", row.grade ? json::value(scoring::NameOf(*row.grade)) : json::value()},
                   {"borderline", row.borderline},
                   {"error", row.error},
                   {"source", row.source}});
  }
  return out;
}

}  // namespace

std::string ToJson(const ScoreResult& result) {
  json::array metrics;
  for (const MetricValue& m : result.metrics) {
    json::object metric{{"name", m.name}, {"value", Rounded(m.value)}, {"unit", m.unit}};
    if (m.limited) metric["limited"] = true;
    if (m.below_grid) metric["below_grid"] = Rounded(*m.below_grid);
    if (m.uncertainty) metric["uncertainty"] = Rounded(*m.uncertainty);
    metrics.push_back(std::move(metric));
  }
  json::array missing;
  for (const MissingMetric& m : result.missing) {
    missing.push_back({{"name", m.name}, {"why", stored::NameOf(kWhy, m.why)}});
  }
  json::object out{{"score", Rounded(result.score)},
                   {"critical_fail", result.critical_fail},
                   {"critical", CriticalJson(result.critical)},
                   {"borderline", CriticalJson(result.borderline)},
                   {"board", BoardJson(result.board)},
                   {"points", Rounded(result.points)},
                   {"points_uncertainty", Rounded(result.points_uncertainty)},
                   {"acceptance", stored::NameOf(kAcceptances, result.acceptance)},
                   {"criteria", CriteriaJson(result.criteria)},
                   {"regions", RegionsJson(result)},
                   {"mistakes", MistakesJson(result.mistakes)},
                   {"beyond", Rounded(result.beyond)},
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
                   {"outages", result.outages},
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

}  // namespace enamel::scoring
