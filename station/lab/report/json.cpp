#include <boost/json.hpp>
#include <cmath>

#include "common/program/output.h"
#include "station/lab/report/cutting_report.h"
#include "station/lab/report/report.h"

namespace enamel::station::lab {
namespace {

namespace json = boost::json;

// JSON has no infinities: null means never.
json::value Number(double v) { return std::isfinite(v) ? json::value(v) : json::value(nullptr); }
// Below 0: not reached in the simulated time.
json::value Time(double v) { return v < 0 ? json::value(nullptr) : Number(v); }

json::object RowJson(const Row& r) {
  const Measurement& m = r.m;
  json::object out{{"suite", r.suite},
                   {"title", r.title},
                   {"profile", r.profile},
                   {"law", r.law},
                   {"estimator", r.estimator},
                   {"rate_hz", Number(r.rate_hz)},
                   {"hand", r.hand},
                   {"b_n_s_per_mm", Number(r.b_n_s_per_mm)},
                   {"kc_n_per_mm", Number(r.kc_n_per_mm)},
                   {"steady_error_max_n", Number(m.error_max_n)},
                   {"steady_error_rms_n", Number(m.error_rms_n)},
                   {"felt_error_rms", Number(m.felt_error_rms_n)},
                   {"felt_error_95", Number(m.felt_error_p95_n)},
                   {"ripple_rms_n", Number(m.ripple_rms_n)},
                   {"ripple_above_20_hz_rms_n", Number(m.ripple_fast_rms_n)},
                   {"deviation_m", Number(m.deviation_m)},
                   {"mean_n", Number(m.mean_n)},
                   {"target_n", Number(m.target_n)},
                   {"speed_mm_s", Number(r.speed_mm_s)},
                   {"rise90_s", Time(m.rise90_s)},
                   {"rise90_floor_s", Number(m.rise90_floor_s)},
                   {"release10_s", Time(m.release10_s)},
                   {"kick_n", Number(m.kick_n)},
                   {"tau_s", Number(r.tau_s)},
                   {"energy_min_j", Number(m.energy_min_j)},
                   {"energy_floor_j", Number(m.energy_floor_j)},
                   {"violations", m.violation ? 1 : 0},
                   {"kc_delta_half_n", Number(r.kc_delta_half_n)},
                   {"cycle", m.cycle},
                   {"ns_per_tick", Number(r.ns_per_tick)},
                   {"stability", VerdictName(r.verdict)},
                   {"pareto", r.pareto},
                   {"default", r.is_default}};
  for (const auto& [what, value] : r.extra) out[what] = Number(value);
  return out;
}

// Every row has every member, null if it does not apply, so readers need not guess.
json::object HandJson(const HandRow& r) {
  return {{"suite", "hand"},
          {"device", r.device},
          {"b_n_s_per_mm", Number(r.b_n_s_per_mm)},
          {"rate_hz", Number(r.rate_hz)},
          {"on_board", r.on_board},
          {"kc_n_per_mm", Number(r.kc_n_per_mm)},
          {"hand_n_per_mm", Number(r.hand_n_per_mm)},
          {"hand_kg", Number(r.hand_kg)},
          {"motion", r.motion},
          {"lattice", r.lattice},
          {"delay_ticks", r.delay_ticks},
          {"proved", r.proved},
          {"felt_error", Number(r.felt_error)},
          {"maxwell_error", Number(r.maxwell_error)},
          {"ideal_rms_n", Number(r.ideal_rms_n)},
          {"felt_error_rms", Number(r.felt_error_rms_n)},
          {"felt_error_95", Number(r.felt_error_p95_n)},
          {"tool_rms_n", Number(r.tool_rms_n)},
          {"ripple_n", Number(r.ripple_n)},
          {"maxwell_ripple_n", Number(r.maxwell_ripple_n)},
          {"off_rms_n", Number(r.off_rms_n)},
          {"least_share", Number(r.least_share)},
          {"swing_n", Number(r.swing_n)},
          {"maxwell_swing_n", Number(r.maxwell_swing_n)},
          {"pull_n", Number(r.pull_n)},
          {"cycles", r.cycles},
          {"excess_n", Number(r.excess_n)},
          {"way_m", Number(r.way_m)},
          {"maxwell_way_m", Number(r.maxwell_way_m)},
          {"behind_m", Number(r.behind_m)},
          {"energy_min_j", Number(r.energy_min_j)}};
}

json::object ExtremeJson(const ExtremeRow& r) {
  return {{"suite", "extreme"},
          {"case", r.name},
          {"device", r.device},
          {"hand", r.hand},
          {"quantity", r.quantity},
          {"unit", r.unit},
          {"expected", r.Expected()},
          {"least", Number(r.least)},
          {"most", Number(r.most)},
          {"found", Number(r.found)},
          {"command_error_rms_n", Number(r.command_error_rms_n)},
          {"felt_error_rms", Number(r.felt_error_rms_n)},
          {"within_peak", r.within_peak},
          {"stability", VerdictName(r.stability)},
          {"verdict", r.Passed() ? "passed" : "failed"}};
}

json::object BudgetJson(const BudgetRow& r) {
  json::array parts;
  for (const fidelity::FeltPart& p : r.budget.parts)
    parts.push_back(json::object{{"cause", p.cause},
                                 {"rms_n", Number(p.rms_n)},
                                 {"n_95", Number(p.p95_n)},
                                 {"share", Number(p.share)}});
  return {{"suite", "felt-budget"},
          {"device", r.device},
          {"hand", r.hand},
          {"b_n_s_per_mm", Number(r.b_n_s_per_mm)},
          {"speed_mm_s", Number(r.speed_mm_s)},
          {"felt_error_rms", Number(r.budget.rms_n)},
          {"felt_error_95", Number(r.budget.p95_n)},
          {"tool_rms_n", Number(r.budget.tool_rms_n)},
          {"parts", std::move(parts)}};
}

json::object SecondsJson(const SecondsRow& r) {
  return {{"suite", "felt-seconds"},
          {"device", r.device},
          {"b_n_s_per_mm", Number(r.b_n_s_per_mm)},
          {"speed_mm_s", Number(r.speed_mm_s)},
          {"seconds", r.seconds},
          {"within", r.within}};
}

json::object StrokeJson(const StrokeRow& r) {
  return {{"suite", "strokes"},
          {"exercise", r.exercise},
          {"stroke", r.stroke},
          {"device", r.device},
          {"calibrated", r.calibrated},
          {"hand_n_per_mm", Number(r.hand_n_per_mm)},
          {"felt_error", Number(r.felt_error())},
          {"felt_error_rms", Number(r.felt_error_rms_n)},
          {"tool_rms_n", Number(r.tool_rms_n)},
          {"b_n_s_per_mm", Number(r.b_n_s_per_mm)},
          {"speed_mm_s", Number(r.speed_mm_s)},
          {"removal_s", Number(r.removal_s)}};
}

json::object PeckJson(const PeckRow& r) {
  return {{"suite", "pecks"},
          {"device", r.device},
          {"calibrated", r.calibrated},
          {"rate_hz", Number(r.rate_hz)},
          {"b_n_s_per_mm", Number(r.peck.b_n_s_per_m * 1e-3)},
          {"press_n", Number(r.peck.press_n)},
          {"contact_s", Number(r.peck.contact_s)},
          {"depth_um", Number(r.figures.depth_m * 1e6)},
          {"tool_depth_um", Number(r.figures.tool_depth_m * 1e6)},
          {"depth_share", Number(r.depth_share())},
          {"felt_error", Number(r.felt_error())}};
}

json::object WatchJson(const WatchRow& r) {
  return {{"suite", "watch"},
          {"device", r.device},
          {"delay_ticks", r.delay_ticks},
          {"hand", r.hand},
          {"profile_error", r.error},
          {"trials", r.trials},
          {"swings", r.swings},
          {"caught", r.caught},
          {"caught_within_200_ms", r.soon},
          {"within_s", r.caught > 0 ? Number(r.within_s) : json::value(nullptr)},
          {"false_alarms", r.false_alarms},
          {"swing_n", Number(r.swing_n)},
          {"left_n", Number(r.left_n)}};
}

void AppendFront(const JointFront& front, json::array& rows) {
  const JointPoint* best = BestWithin(front.points, kNoBudget_us);
  for (const JointPoint& p : front.points) {
    json::object out = JointPointJson(p);
    out["suite"] = "joint-front";
    out["device"] = front.device;
    out["recommended"] = &p == best;
    rows.push_back(std::move(out));
  }
}

json::object CurveJson(const FeelCurve& c) {
  return {{"device", c.device},
          {"title", c.title},
          {"tissue", c.tissue},
          {"b_n_s_per_mm", Number(c.b_n_s_per_mm)},
          {"law", c.law},
          {"rate_hz", Number(c.rate_hz)},
          {"delay_ticks", c.delay_ticks},
          {"kc_n_per_mm", Number(c.kc_n_per_mm)},
          {"calibrated", c.calibrated},
          {"limit", c.limit},
          {"friction_n", Number(c.friction_n)},
          {"error", json::array(c.error.begin(), c.error.end())},
          {"closed_form", json::array(c.closed_form.begin(), c.closed_form.end())}};
}

}  // namespace

json::object JointPointJson(const JointPoint& p) {
  return {{"law", haptics::FindLaw(p.law.law)->name},
          {"choice", p.law.Name()},
          {"voxel_nm", p.voxel_nm},
          {"rate_hz", Number(p.rate_hz)},
          {"mean_us", Number(p.tick.mean_us.value)},
          {"mean_us_95", json::array{p.tick.mean_us.low, p.tick.mean_us.high}},
          {"p99_us", Number(p.tick.p99_us.value)},
          {"p99_us_95", json::array{p.tick.p99_us.low, p.tick.p99_us.high}},
          {"load", Number(p.load())},
          {"hand_error", Number(p.hand_error)},
          {"voxel_error", Number(p.voxel_error)},
          {"felt_error", Number(p.felt_error)},
          {"felt_error_rms", Number(p.felt_error_rms_n)},
          {"passive", p.proved},
          {"runs", p.runs},
          {"on_front", p.on_front},
          {"default", p.is_default}};
}

json::object FeelJson(const std::vector<FeelCurve>& curves) {
  json::array grips, shares, all;
  for (double grip : fidelity::kGrips_n_per_m) grips.push_back(Number(grip * 1e-3));
  for (double share : fidelity::kShares) shares.push_back(Number(share));
  for (const FeelCurve& c : curves) all.push_back(CurveJson(c));
  return {{"enamel_feel", 1},
          {"grips_n_per_mm", std::move(grips)},
          {"shares", std::move(shares)},
          {"hand_rad_per_s", fidelity::kHand_rad_per_s},
          {"curves", std::move(all)}};
}

std::string JsonOf(const Findings& f) {
  json::array rows, fronts, attacks, random;
  // A hand row has other members than a point of the front of hands against run time.
  for (const Row& r : f.rows) (r.suite == "hand-front" ? fronts : rows).push_back(RowJson(r));
  AppendCuttingRows(f, rows);
  for (const HandRow& r : f.hands) rows.push_back(HandJson(r));
  for (const JointFront& front : f.fronts) AppendFront(front, rows);
  for (const BudgetRow& r : f.budgets) rows.push_back(BudgetJson(r));
  for (const SecondsRow& r : f.seconds_felt) rows.push_back(SecondsJson(r));
  for (const StrokeRow& r : f.exercise_strokes) rows.push_back(StrokeJson(r));
  for (const PeckRow& r : f.pecks) rows.push_back(PeckJson(r));
  for (const WatchRow& r : f.watch) rows.push_back(WatchJson(r));
  for (const ExtremeRow& r : f.extremes) rows.push_back(ExtremeJson(r));
  for (const Attack& a : f.attacks) {
    attacks.push_back(json::object{{"law", a.law},
                                   {"game", a.kind},
                                   {"profile", a.profile},
                                   {"seed", a.seed},
                                   {"length", a.length},
                                   {"ticks", a.ticks},
                                   {"lowest_above_floor_j", Number(a.worst_j)},
                                   {"extracted_j", Number(a.extracted_j)},
                                   {"violations", a.violations},
                                   {"proved", a.proved}});
  }
  for (const RandomSummary& r : f.random) {
    random.push_back(json::object{{"draw", r.title},
                                  {"cases", r.cases},
                                  {"held", r.held},
                                  {"ripple", r.ripple},
                                  {"error", r.error}});
  }
  json::object out{{"format", 1},
                   {"seed", f.seed},
                   {"quick", f.quick},
                   {"integration_error_m", Number(f.integration_error_m)},
                   {"rows", std::move(rows)},
                   {"attacks", std::move(attacks)},
                   {"random", std::move(random)}};
  // Left out if no such suite ran; the same for the members below.
  if (!fronts.empty()) out["fronts"] = std::move(fronts);
  if (!f.feel.empty()) out["feel"] = FeelJson(f.feel);
  out["report"] = ReportOf(f);
  std::string text = program::JsonText(out);
  if (!f.strokes.empty()) {
    // Appended as text: the strokes have their own writer, with fewer digits than a library's.
    text.pop_back();
    text += ",\"strokes\":" + StrokesJson(f.strokes) + "}";
  }
  return text;
}

}  // namespace enamel::station::lab
