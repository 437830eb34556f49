#pragma once

#include <string>
#include <utility>
#include <vector>

#include "common/fidelity/feel.h"
#include "station/lab/cutting/cutting_error.h"
#include "station/lab/laws/hand_trial.h"
#include "station/lab/laws/model.h"
#include "station/lab/laws/strokes.h"

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
  // front.h. "error_over_oracle": human-motion error relative to the memoryless oracle's; "pull_n".
  std::vector<std::pair<std::string, double>> extra;
  Verdict verdict = Verdict::kStable;
  bool pareto = false, is_default = false;
};

// A number as tables show it. `format`: printf's, of one number.
std::string F(double v, const char* format = "%.3f");

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
  std::string law, kind;  // kind: how the motion was made, or the rules of a game of adversary.h
  std::string made;       // of such a game, how the worst was made
  // Arguments that repeat the worst: PlayRandom, PlaySearch or PlayGame with this profile, law,
  // seed and length (ticks, or rounds of the search).
  std::string profile;
  uint64_t seed = 0;
  int64_t length = 0;
  int64_t ticks = 0;
  double worst_j = 0;      // lowest balance above its floor; < 0: violation
  double extracted_j = 0;  // most energy taken out of the law itself
  int64_t violations = 0;
  bool proved = false;
};

struct RandomSummary {
  std::string title;  // how speeds were drawn
  int cases = 0, held = 0, error = 0, rise = 0, release = 0, cycle = 0;
  std::vector<Row> failures;
  std::vector<double> errors_n, rises,
      releases;  // velocity-hand figures of every case, over their bounds
};

// One motion of one hand on one device. Rows with a track compare R with B v tick by tick; the
// others are withdrawals with the product's core.
struct HandRow {
  std::string device, motion, hand, lattice, law;
  double b_n_s_per_mm = 0, rate_hz = 1000, kc_n_per_mm = 0;
  int delay_ticks = 0;
  bool has_track = false;
  HandFigures f;
  // Withdrawals: the opposing part, beyond Kc delta if that is larger than 0.15 N, else the part
  // itself; its largest rise in a tick; the excess of a step of the force over Kc (v T + sqrt(3)
  // delta).
  double opposing_n = 0, pull_n = 0, rise_n = 0, step_n = 0;
};

// One cell of the map of what a hand can feel.
struct FeelRow {
  std::string device, tissue;
  double b_n_s_per_mm = 0, kc_n_per_mm = 0;
  int delay_ticks = 0;
  bool attached = false;  // delay and Kc as an attached unit has them, else as the profile says
  fidelity::Cell cell;
};

// One device at one loop rate with the largest coupling possible there (scene/rate.h), in five
// hands that wander over enamel of 6.5 N s/mm at 0.2 mm/s. JSON: member "rates", the names below.
struct RateRow {
  std::string device,
      limit;  // limit: what keeps Kc from being larger: damping, friction, structure
  double rate_hz = 0, kc_n_per_mm = 0;
  int delay_ticks = 0;
  double kc_delta_half_n = 0;    // what one encoder cell is worth: the least error per axis
  double lag_s = 0;              // at which R and B v correlate best, mean
  double error_rms = 0;          // RMS of R - B v over that of B v
  double error_over_oracle = 0;  // the same over the oracle's at this Kc
};

// One bur at one voxel size and speed.
struct CuttingRow {
  CuttingFigures figures;
  bool pareto = false;
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
  std::vector<HandRow> hands;
  std::vector<FeelRow> feel;
  std::vector<StrokeDevice> strokes;
  std::vector<RateRow> rates;
  std::vector<ScoreFigures> scores;  // coarse to fine
  double integration_error_m = 0;    // the simulator's own, worst of the trials asked
  double seconds = 0;
  uint64_t seed = 1;
  bool quick = false;
};

}  // namespace enamel::station::lab
