#pragma once

#include <algorithm>
#include <iterator>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/scoring/score.h"

// The members of a stored score (schemas/score.md), each once, in the order in which it is written. For score_json.cpp
// only. A visitor V writes or reads them:
//   v(name, value)            text, number, true or false, three numbers, lists of numbers and texts
//   v(name, value, unit)      numbers that are stored in `unit`, which is given in SI
//   v.Enum, v.Named           one of a few names
//   v.IfAny, v.OrNull         absent or null where there is none
//   v.Derived                 written for readers who would have to compute it, and not read
//   v.List, v.Object          of objects, whose members `each` visits
namespace enamel::scoring::stored {

inline constexpr double kMm = 1e-3, kMm3 = 1e-9, kPercent = 0.01;
inline constexpr size_t kMaxMetrics = 1024;

template <typename T>
using Name = std::pair<T, std::string_view>;
inline constexpr Name<NoValue> kWhy[] = {{NoValue::kNotInTask, "not_in_task"},
                                         {NoValue::kNotMade, "not_made"},
                                         {NoValue::kNotUsed, "not_used"}};
inline constexpr Name<Acceptance> kAcceptances[] = {{Acceptance::kAcceptable, "acceptable"},
                                                    {Acceptance::kWithRemarks, "with_remarks"},
                                                    {Acceptance::kNotAcceptable, "not_acceptable"}};
// The side of a region that costs more; true: what was cut too far.
inline constexpr Name<bool> kSides[] = {{true, "over"}, {false, "left"}};

// const where V writes.
template <typename V, typename T>
using Of = std::conditional_t<V::kWrites, const T, T>;

template <typename V, typename List>
void Each(V& v, const char* name, List& list, size_t max_size) {
  v.List(name, list.size(), max_size, [&](auto& item, size_t i) {
    if constexpr (!V::kWrites) list.emplace_back();
    Members(item, list[i]);
  });
}

template <typename V>
void Members(V& v, Of<V, CriticalResult>& c) {
  v("error", c.error);
  v("name", c.name);
  v("value", c.value);
  v("unit", c.unit);
  v("limit", c.limit);
  v("above", c.above);
  v("uncertainty", c.uncertainty);
  v("reason", c.reason);
}

template <typename V>
void Members(V& v, Of<V, BoardRow>& row) {
  v.Enum("category", row.category, kGroups);
  v.OrNull("grade", row.grade, [&](auto& grade) { v.Enum("grade", grade, kBoardGrades); });
  v("borderline", row.borderline);
  v("error", row.error);
  v("source", row.source);
}

template <typename V>
void Members(V& v, Of<V, Reason>& r) {
  v("code", r.code);
  v("values", r.values, 1, kMaxReasonValues);
  v("units", r.units, kMaxReasonValues);
}

template <typename V>
void Members(V& v, Of<V, CriterionResult>& c) {
  v("name", c.name);
  v.Enum("group", c.group, kGroups);
  v("title", c.title);
  v("value", c.value);
  v("unit", c.unit);
  v("lost", c.lost);
  v("most", c.most);
  v.Enum("state", c.state, kStates);
  v("judged", c.judged);
  v("reason", c.reason);
  Each(v, "reasons", c.reasons, kMaxReasons);
  v("comment", c.comment);
}

// A region and its cost make one object.
template <typename V>
void Members(V& v, Of<V, RegionMeasure>& m, Of<V, RegionCost>& cost) {
  v("name", m.name);
  v("kind", m.kind);
  v.Derived("group", [&] { return NameOf(GroupOf(m.kind)); });
  v("over", m.over);
  v("left", m.left);
  v.Derived("unit", [&] { return UnitOf(m.kind); });
  v("uncertainty", m.uncertainty);
  v.Named("dearer", cost.over, kSides);
  v("lost", cost.lost);
  v.Enum("state", cost.state, kStates);
}

template <typename V>
void Members(V& v, Of<V, Mistake>& m) {
  v.Enum("kind", m.kind, kMistakeKinds);
  v("place", m.place);
  v("size", m.size);
  v.Derived("unit", [&] { return UnitOf(m.kind); });
  v("points", m.points);
  v.Enum("group", m.group, kGroups);
  v("at_mm", m.at_m, kMm);
  v("towards", m.towards);
}

template <typename V>
void Members(V& v, Of<V, MetricValue>& m) {
  v("name", m.name);
  v("value", m.value);
  v("unit", m.unit);
  v.IfAny("limited", m.limited);
  v.IfAny("below_grid", m.below_grid);
  v.IfAny("uncertainty", m.uncertainty);
}

template <typename V>
void Members(V& v, Of<V, MissingMetric>& m) {
  v("name", m.name);
  v.Named("why", m.why, kWhy);
}

template <typename V>
void Members(V& v, Of<V, FaultStroke>& stroke) {
  v("number", stroke.number);
  v("first_tick", stroke.first_tick);
  v("first_s", stroke.first_s);
  v("lasts_s", stroke.lasts_s);
  v("volume_mm3", stroke.volume_m3, kMm3);
}

template <typename V>
void Members(V& v, Of<V, Deduction>& d) {
  v("mistake", d.mistake);
  v("left", d.left);
  v("volume_mm3", d.volume_m3, kMm3);
  v("position_mm", d.position_m, kMm);
  v("facing", d.facing);
  v("first_tick", d.first_tick);
  v("first_s", d.first_s);
  v("here", d.here);
  v("half_tick", d.half_tick);
  v("half_s", d.half_s);
  v("stroke_count", d.stroke_count);
  v("strokes_mm3", d.strokes_m3, kMm3);
  Each(v, "strokes", d.strokes, Deduction::kMaxStrokes);
}

template <typename V>
void Members(V& v, Of<V, EnvelopeOverlap>& m) {
  v("attempt", m.attempt);
  v("overlap_percent", m.dice, kPercent);
}

template <typename V>
void Members(V& v, Of<V, MetricPlace>& p) {
  v("name", p.name);
  v("unit", p.unit);
  v("least", p.least);
  v("median", p.median);
  v("most", p.most);
  v("spread", p.spread);
  v.OrNull("z", p.z, [&](auto& z) { v("z", z); });
  v("percentile", p.percentile);
}

template <typename V>
void Members(V& v, Of<V, Envelope>& e) {
  Each(v, "references", e.members, kMaxEnvelopeMembers);
  v("left_of_all_mm3", e.left_of_all_m3, kMm3);
  v("disputed_mm3", e.disputed_m3, kMm3);
  v("taken_by_mm3", e.taken_by_m3, kMm3, kMaxEnvelopeMembers + 1);
  Each(v, "metrics", e.metrics, kMaxMetrics);
}

template <typename V>
void Members(V& v, Of<V, Disturbance>& d) {
  v.Derived("disturbed", [&] { return d.disturbed(); });
  v("late_percent", d.late_percent);
  v("gap_percent", d.gap_percent);
  v("limited_percent", d.limited_percent);
}

template <typename V>
void Members(V& v, Of<V, ScoreResult>& s) {
  v("score", s.score);
  v("critical_fail", s.critical_fail);
  Each(v, "critical", s.critical, kMaxCritical);
  Each(v, "borderline", s.borderline, kMaxCritical + 1);  // the pass limit may be beside those
  Each(v, "board", s.board, kGroups);
  v("points", s.points);
  v("points_uncertainty", s.points_uncertainty);
  v.Named("acceptance", s.acceptance, kAcceptances);
  Each(v, "criteria", s.criteria, kMaxCriteria);
  v.List("regions", s.measures.size(), kMaxMeasures, [&](auto& item, size_t i) {
    if constexpr (!V::kWrites) s.measures.emplace_back(), s.costs.emplace_back();
    Members(item, s.measures[i], s.costs[i]);
  });
  Each(v, "mistakes", s.mistakes, kMaxMistakes);
  v("beyond", s.beyond);
  Each(v, "metrics", s.metrics, kMaxMetrics);
  Each(v, "missing", s.missing, kMaxMetrics);
  Each(v, "deductions", s.deductions, kMaxDeductions);
  v.OrNull("envelope", s.envelope, [&](auto& envelope) { v.Object("envelope", envelope); });
  v("reference_attempt", s.reference_attempt);
  v("rubric_version", s.rubric_version);
  v("scoring_version", s.scoring_version);
  v("core_version", s.core_version);
  v("ticks", s.ticks);
  v("gap_ticks", s.gap_ticks);
  v("late_ticks", s.late_ticks);
  v("outages", s.outages);
  v("bounded_ticks", s.bounded_ticks);
  v.Object("disturbance", s.disturbance);
  v("witness_ok", s.witness_ok);
  v("witness_note", s.witness_note);
}

}  // namespace enamel::scoring::stored
