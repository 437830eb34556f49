#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/fidelity/budget.h"
#include "common/fidelity/feel.h"
#include "station/lab/cutting/cutting_error.h"
#include "station/lab/cutting/order.h"
#include "station/lab/laws/model.h"
#include "station/lab/laws/pecks.h"
#include "station/lab/laws/strokes.h"
#include "station/lab/suites/joint_front.h"

// The suites' findings as data, the source of tables, JSON and report.
namespace enamel::station::lab {

enum class Verdict { kPassive, kStable, kBounded, kUnstable };
// "passive", "stable with these grips", "bounded", "unstable".
const char* VerdictName(Verdict v);

// One cut: device x law x estimator x rate x material x hand.
struct Row {
  std::string suite, profile, law, estimator, hand, title;
  double rate_hz = 1000, b_n_s_per_mm = 0, speed_mm_s = 0, kc_n_per_mm = 0;
  double tau_s = 0, kc_delta_half_n = 0, ns_per_tick = 0;
  Measurement m;
  // Other measures of a suite, by name: written beside the other members in JSON and read by
  // front.h. "felt_error": of the force in a wandering hand of 1 N/mm, a share; "pull_n".
  std::vector<std::pair<std::string, double>> extra;
  Verdict verdict = Verdict::kStable;
  bool pareto = false, is_default = false;
};

// A number as tables show it. `format`: printf's, of one number.
std::string F(double v, const char* format = "%.3f");

// One extreme case, and what must come out of it: a figure between two bounds. Every force must also be finite and
// within the motors' peak.
struct ExtremeRow {
  std::string name, device, hand;  // hand: empty where the motion is given tick by tick
  std::string quantity, unit;      // what is bounded
  double least = -std::numeric_limits<double>::infinity(),
         most = std::numeric_limits<double>::infinity();
  double found = 0;
  // Where a hand was simulated: RMS off B V of the force sent and of the force in the hand (laws/trial.h).
  double command_error_rms_n = std::numeric_limits<double>::quiet_NaN(),
         felt_error_rms_n = std::numeric_limits<double>::quiet_NaN();
  bool within_peak = false;
  Verdict stability = Verdict::kBounded;

  bool Passed() const { return within_peak && found >= least && found <= most; }
  std::string Expected() const;  // "0 N", "at most 12 N", "11.9 to 12 N"
  std::string Found() const;
};

struct Table {
  std::string title, note;
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;
};

// A grid of verdicts with curves over it.
struct VerdictMap {
  std::string title, x_label, y_label, note;
  std::vector<double> x, y;    // cell centres, logarithmic axes
  std::vector<Verdict> cells;  // (y.size() x x.size()), x fastest
  struct Curve {
    std::string label;
    std::vector<std::pair<double, double>> points;
  };
  std::vector<Curve> curves;
};

// Force over time of one law in one hand.
struct TimeTrace {
  std::string title, label;  // plots with one title are drawn into one frame
  double target_n = 0;
  std::vector<Sample> samples;
};

// One game of the adversary; of games merged into one line, the worst, with the ticks of all.
struct Attack {
  std::string law, kind;  // target and rules of adversary.h
  std::string made;       // how the worst was made
  // Arguments that repeat the worst: PlayGame with this profile, target, seed and length (ticks, or
  // rounds of the search).
  std::string profile;
  uint64_t seed = 0;
  int64_t length = 0;
  int64_t ticks = 0;
  double worst_j = 0;      // lowest balance above its floor; < 0: violation
  double extracted_j = 0;  // most energy taken out of the law itself
  int64_t violations = 0;
  bool proved = false;
};

// Random cases of one draw, each in four hands.
struct RandomSummary {
  std::string title;  // how they were drawn
  // Of the cases: ripple beyond the plain spring's + 0.05 N, felt error beyond its + 1 point.
  int cases = 0, held = 0, ripple = 0, error = 0;
  std::vector<std::string> misses;  // a line each: what, by how much, and what repeats it
  // Of every hand of every case, beyond the plain spring's.
  std::vector<double> ripples_n, errors;
};

inline constexpr double kNotApplicable = std::numeric_limits<double>::quiet_NaN();

// One motion of one hand on one device, the default law beside plain Maxwell. Every row has every
// figure; what does not apply is kNotApplicable, and null in JSON.
struct HandRow {
  std::string device, motion, lattice = "cartesian";
  double b_n_s_per_mm = 6.5, rate_hz = 1000, kc_n_per_mm = 0;
  double hand_n_per_mm = kNotApplicable;  // none: the hand prescribes the way; 0: it pushes
  double hand_kg = kNotApplicable;
  int delay_ticks = 0;
  bool on_board =
      false;  // the board runs the spring, at rate_hz; the host runs the law a thousand times a second
  bool proved = false;  // Kc, friction, cell and delay meet the clause of common/haptics/README.md
  // RMS of force sent less that of an ideal damper in the same hand on the same device, over the latter's.
  double felt_error = kNotApplicable, maxwell_error = kNotApplicable;
  double ideal_rms_n = kNotApplicable;  // of the damper's force
  // The force in the hand, friction, damping and inertia in, against an ideal tool (fidelity/felt.h): RMS of the
  // error, what 95 % of the ticks are within, RMS of the tool's force.
  double felt_error_rms_n = kNotApplicable, felt_error_p95_n = kNotApplicable,
         tool_rms_n = kNotApplicable;
  double ripple_n = kNotApplicable, maxwell_ripple_n = kNotApplicable;  // RMS above 15 Hz
  // Steady cuts: RMS off B v, and the least force as a share of it.
  double off_rms_n = kNotApplicable, least_share = kNotApplicable;
  double swing_n = kNotApplicable, maxwell_swing_n = kNotApplicable;  // peak to peak, settled
  double pull_n = kNotApplicable;    // largest force against a lift or a withdrawal
  int cycles = 0;                    // 1: the hand was thrown back and came again
  double excess_n = kNotApplicable;  // first stroke after air
  double way_m = kNotApplicable, maxwell_way_m = kNotApplicable;  // until 0.1 N are felt
  double behind_m = kNotApplicable;                               // the bur behind the tip in air
  double energy_min_j = kNotApplicable;                           // of the theorem's balance
};

// What the error of the force in one hand is made of (fidelity/budget.h).
struct BudgetRow {
  std::string device, hand;
  double b_n_s_per_mm = 0, speed_mm_s = 0;
  fidelity::FeltBudget budget;
};

// How many seconds of strokes in a grip of 1 N/mm are felt right: error of the force in the hand within
// fidelity::kShares[1] of the ideal tool's, both RMS over the second.
struct SecondsRow {
  std::string device;
  double b_n_s_per_mm = 0, speed_mm_s = 0;
  int seconds = 0, within = 0;
  double share() const { return seconds > 0 ? static_cast<double>(within) / seconds : 0; }
};

// One stroke of a built-in exercise in one hand on one device, as shipped or after a calibration.
struct StrokeRow {
  std::string exercise, stroke, device;
  bool calibrated = false;
  double hand_n_per_mm = 0;
  // Of the force in the hand (fidelity::FeltFigures): RMS of the error and of the tool's force.
  double felt_error_rms_n = 0, tool_rms_n = 0;
  double b_n_s_per_mm = 0, speed_mm_s = 0;
  double removal_s = 0;  // of the exercise's removal that it stands for

  double felt_error() const { return tool_rms_n > 0 ? felt_error_rms_n / tool_rms_n : 0; }
};

// A short touch on one device (laws/pecks.h).
struct PeckRow {
  std::string device;
  bool calibrated = false;
  double rate_hz = 0;
  Peck peck;
  PeckFigures figures;

  double depth_share() const { return figures.depth_m / figures.tool_depth_m; }
  double felt_error() const { return figures.felt_error_rms_n / figures.tool_rms_n; }
};

// The watch for swings: the trials of one hand on one device with one error in its profile (laws/swings.h).
struct WatchRow {
  std::string device, hand, error;
  int delay_ticks = 0;  // that the law is told
  int trials = 0, swings = 0, caught = 0;
  int soon = 0;          // caught within 0.2 s of the first excursion beyond 1 N
  int false_alarms = 0;  // of the right profile
  double within_s = 0;   // mean of those caught
  double swing_n = 0,
         left_n = 0;  // largest peak to peak in the last second: without the watch, with it
};

// One curve of the map of what a hand can feel: an error for each grip of fidelity::kGrips_n_per_m.
// JSON: schemas/feel.schema.json.
struct FeelCurve {
  std::string device, title, tissue, law;
  double b_n_s_per_mm = 0, rate_hz = 0, kc_n_per_mm = 0, friction_n = 0;
  int delay_ticks = 0;
  bool calibrated = false;  // Unit
  std::string limit;  // what keeps Kc from being larger (scene/rate.h); empty: the profile's own Kc
  std::vector<double> error;
  std::vector<double> closed_form;  // of the law's spring for slow motion, without friction
};

// One bur at one voxel size and speed.
struct CuttingRow {
  CuttingFigures figures;
  bool pareto = false;

  // Over its grids.
  double RmsOf(double CutErrors::*error) const {
    std::vector<double> all;
    for (const CutErrors& e : figures.grids) all.push_back(e.*error);
    return Rms(all);
  }
};

// How one figure falls with its step: the voxel, or the time step.
struct OrderRow {
  std::string method;              // cutting, scores, meshes, pictures, plants (orders.h)
  std::string what;                // "cylinder r 0.6 x 4 mm, groove, 5 mm/s"
  std::optional<CutCase> cut;      // of cutting: its voxel and grid are not used
  std::string quantity, unit;      // volume, surface_p95, force, …
  std::string step_unit;           // mm: a voxel; us: a time
  std::vector<double> steps, rms;  // coarse to fine, RMS over grids that lie differently, or hands
  ObservedOrder observed;          // of the last halving
  double floor = kNotApplicable;   // the RMS at the finest step, where it no longer falls
  double converged_from =
      kNotApplicable;  // of the energy of a closed loop: within 2 % from this step on
};

// Of one device (joint_front.h).
struct JointFront {
  std::string device, title;
  std::vector<JointPoint> points;
};

struct Findings {
  std::vector<DeviceModel> models;
  std::vector<Row> rows;
  std::vector<Table> tables;
  std::vector<VerdictMap> maps;
  std::vector<TimeTrace> traces;
  std::vector<Attack> attacks;
  std::vector<RandomSummary> random;
  std::vector<CuttingRow> cutting;
  std::vector<OrderRow> orders;
  std::vector<HandRow> hands;
  std::vector<BudgetRow> budgets;
  std::vector<SecondsRow> seconds_felt;
  std::vector<JointFront> fronts;
  std::vector<ExtremeRow> extremes;
  std::vector<FeelCurve> feel;
  std::vector<StrokeDevice> strokes;  // of the suite "withdrawal"
  std::vector<StrokeRow> exercise_strokes;
  std::vector<PeckRow> pecks;
  std::vector<WatchRow> watch;
  std::vector<ScoreFigures> scores;  // coarse to fine
  double integration_error_m = 0;    // the simulator's own, worst of the trials asked
  double seconds = 0;
  uint64_t seed = 1;
  bool quick = false;
};

}  // namespace enamel::station::lab
