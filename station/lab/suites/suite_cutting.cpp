#include <algorithm>
#include <cmath>

#include "common/cutting/voxel_limit.h"
#include "station/lab/cutting/force_error.h"
#include "station/lab/suites/orders.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

// A minute at 1 kHz, over which the hand spreads its strokes (cutting/attempt.cpp).
constexpr uint64_t kScoreTicks = 60'000;

bool SameCut(const CuttingFigures& a, const CuttingFigures& b) {
  return a.c.bur == b.c.bur && a.c.speed_m_s == b.c.speed_m_s && a.c.plunge == b.c.plunge;
}

// On the front: no other voxel size of the same bur and speed is both cheaper and more exact.
void MarkFront(std::vector<CuttingRow>& rows) {
  for (CuttingRow& row : rows) {
    row.pareto = std::none_of(rows.begin(), rows.end(), [&](const CuttingRow& other) {
      const CuttingFigures &a = other.figures, &b = row.figures;
      const double off = row.RmsOf(&CutErrors::surface_p95_um),
                   other_off = other.RmsOf(&CutErrors::surface_p95_um);
      bool no_worse = a.cost.mean_us <= b.cost.mean_us && other_off <= off;
      bool better = a.cost.mean_us < b.cost.mean_us || other_off < off;
      // Another bur or speed is another task, not a cheaper way to do this one.
      return SameCut(a, b) && no_worse && better;
    });
  }
}

const char* WayOf(const CutCase& c) { return c.plunge ? "plunge" : "groove"; }

Table CuttingTable(const Findings& f) {
  Table t;
  t.title = "Cutting against swept bodies: voxel size, bur, speed";
  t.head = {"bur",         "way",          "voxel mm",       "mm/s",
            "removed mm3", "volume RMS %", "surface p95 um", "force N",
            "force RMS %", "us a tick",    "p99 us",         "front"};
  t.note =
      "A groove half the bur's height deep, or a plunge along its axis; block and bur turned off "
      "the grid together. Each error is the RMS over grids that lie differently. Volume: against "
      "the closed form. Surface: the hole's mesh against the swept body, rims included. Force: "
      "its mean against B v of the front. "
      "Microseconds: per tick the least of several identical replays. Front: no other voxel size "
      "of this bur, way and speed is both cheaper and closer to the body (p95).";
  for (const CuttingRow& row : f.cutting) {
    const CuttingFigures& c = row.figures;
    t.rows.push_back({cutting::BurText(c.c.bur), WayOf(c.c), F(c.c.voxel_mm(), "%.3g"),
                      F(c.c.speed_m_s * 1e3, "%g"), F(c.grids[0].removed_mm3),
                      F(100 * row.RmsOf(&CutErrors::volume), "%.3f"),
                      F(row.RmsOf(&CutErrors::surface_p95_um), "%.2f"), F(c.grids[0].force_mean_n),
                      F(100 * row.RmsOf(&CutErrors::force), "%.2f"), F(c.cost.mean_us, "%.1f"),
                      F(c.cost.p99_us, "%.1f"), row.pareto ? "yes" : ""});
  }
  return t;
}

struct Quantity {
  const char* name;
  const char* unit;
  double CutErrors::*of;
  double scale;
};
constexpr Quantity kQuantities[] = {{"volume", "%", &CutErrors::volume, 100},
                                    {"surface_p95", "um", &CutErrors::surface_p95_um, 1},
                                    {"force", "%", &CutErrors::force, 100}};

std::vector<double> ErrorsOf(const CuttingRow& row, const Quantity& q) {
  std::vector<double> out;
  for (const CutErrors& e : row.figures.grids) out.push_back(e.*q.of * q.scale);
  return out;
}

// Expects the rows of one cut one after the other, coarse to fine.
std::vector<OrderRow> OrdersOf(const std::vector<CuttingRow>& rows) {
  std::vector<OrderRow> out;
  for (size_t from = 0, to = 0; from < rows.size(); from = to) {
    while (to < rows.size() && SameCut(rows[from].figures, rows[to].figures)) ++to;
    if (to - from < 2) continue;
    for (const Quantity& q : kQuantities) {
      OrderRow row;
      row.method = "cutting";
      row.cut = rows[from].figures.c;
      row.what = cutting::BurText(row.cut->bur) + ", " + WayOf(*row.cut) + ", " +
                 F(row.cut->speed_m_s * 1e3, "%g") + " mm/s";
      row.quantity = q.name;
      row.unit = q.unit;
      row.step_unit = "mm";
      std::vector<StepErrors> errors;
      for (size_t i = from; i < to; ++i)
        errors.push_back({rows[i].figures.c.voxel_mm(), ErrorsOf(rows[i], q)});
      out.push_back(OrderRowOf(std::move(row), errors));
    }
  }
  return out;
}

// Of what is cut, or of all else.
Table OrderTable(const std::vector<OrderRow>& orders, bool cutting) {
  Table t;
  t.title = cutting
                ? "Cutting: how errors fall with the voxel"
                : "Order: how the errors of scores, meshes, pictures and simulated devices fall";
  t.note =
      cutting
          ? "RMS over grids that lie differently at each voxel, coarse to fine. Order: log2 of "
            "what "
            "the last halving leaves, with 95 % of bootstrap samples of the grids. Floor: the RMS "
            "at "
            "the finest voxel, where the order is below 0.9. Causes: volume and surface, poses "
            "that are passed over "
            "(common/cutting/sweep.h), and a sharp edge that moves along its own slope "
            "(common/cutting/cutter.h). Force: no grid changes how the few points of a bur lie to "
            "the way "
            "(common/cutting/voxel_limit.h)."
          : "Against closed forms, as the voxel or the time step is halved; RMS over eight grids "
            "that lie differently, hands, or starts in a cell. Scores: walls and a floor are "
            "planes, "
            "which distances of 16 bits meet to 1/8192 voxel. Pictures: the outline of the mesh "
            "that "
            "they draw; a picture's own pixel comes on top. Loops have no closed form and are "
            "compared with a step eight times finer than the finest; 'converged from' is the step "
            "from which on they are within 2 % of it. What a light hand gets back depends on where "
            "in a "
            "cell it begins more than on the step.";
  t.head = {"of", "quantity", "error at each step", "order", "95 %", "floor"};
  if (!cutting) t.head.push_back("converged from");
  for (const OrderRow& o : orders) {
    if (cutting != o.cut.has_value()) continue;
    std::string rms;
    for (double e : o.rms) rms += (rms.empty() ? "" : " / ") + F(e, "%.3g");
    const std::string steps = " (" + F(o.steps.front(), "%.3g") + " to " +
                              F(o.steps.back(), "%.3g") + " " + o.step_unit + ")";
    t.rows.push_back({cutting ? o.what : o.method + ": " + o.what, o.quantity,
                      rms + " " + o.unit + steps, F(o.observed.order, "%.2f"),
                      F(o.observed.low, "%.2f") + " to " + F(o.observed.high, "%.2f"),
                      std::isnan(o.floor) ? "" : F(o.floor, "%.3g") + " " + o.unit});
    if (!cutting)
      t.rows.back().push_back(
          std::isnan(o.converged_from) ? "" : F(o.converged_from, "%.3g") + " " + o.step_unit);
  }
  return t;
}

// Which voxel is fine enough for which bur.
Table LimitTable() {
  Table t;
  t.title = "Cutting: error of the force by bur and voxel, %, and what that allows";
  t.note =
      "RMS over twelve ways to travel, in a groove turned off the grid, then the bound that is "
      "kept. *: the bound is beyond 10 %, so that graded work is refused and practice is warned "
      "(common/cutting/voxel_limit.h).";
  t.head = {"bur", "0.2 mm", "0.1 mm", "0.05 mm", "largest voxel, mm"};
  for (const CutCase& c : BurCases()) {
    std::vector<std::string> row = {cutting::BurText(c.bur)};
    for (int32_t voxel_nm : {200'000, 100'000, 50'000}) {
      const double bound = cutting::VoxelForceError(c.bur, voxel_nm);
      row.push_back(F(100 * MeasureForceError(c.bur, voxel_nm), "%.1f") + " / " +
                    F(100 * bound, "%.1f") + (bound > cutting::kMaxVoxelForceError ? " *" : ""));
    }
    row.push_back(F(cutting::LargestVoxel_nm(c.bur) * 1e-6, "%.3f"));
    t.rows.push_back(std::move(row));
  }
  return t;
}

// A coarse grid may miss a small region.
bool SameRegions(const std::vector<ScoreFigures>& scores) {
  return !scores.empty() && std::ranges::all_of(scores, [&](const ScoreFigures& s) {
    return std::ranges::equal(s.regions, scores[0].regions, {}, &RegionFigures::region,
                              &RegionFigures::region);
  });
}

Table ScoreTable(const std::vector<ScoreFigures>& scores) {
  Table t;
  t.title =
      "Scores against voxel size: the same hand, mesial wall 0.3 mm and floor 0.15 mm too deep";
  t.note =
      "A class I cavity in the built-in molar, compared with the same hand's exact cut at the same "
      "voxel size. No closed form is known. Index: Roache's Grid Convergence Index of the finest "
      "voxel, where three halvings agree on its order; elsewhere the last halving's change is all "
      "that is known.";
  t.head = {"figure", "unit"};
  for (const ScoreFigures& s : scores) t.head.push_back(F(s.voxel_nm * 1e-6, "%g") + " mm");
  t.head.insert(t.head.end(), {"last change", "order", "index"});
  auto add = [&](const std::string& name, const std::string& unit, auto&& value) {
    std::vector<std::string> row{name, unit};
    for (const ScoreFigures& s : scores) row.push_back(value(s));
    t.rows.push_back(std::move(row));
  };
  add("whole tooth", "MB", [](const ScoreFigures& s) { return F(s.mb, "%.1f"); });
  add("replay", "x real time", [](const ScoreFigures& s) { return F(s.realtime_factor, "%.0f"); });
  add("score", "points", [](const ScoreFigures& s) { return F(s.points, "%.2f"); });
  for (size_t i = 0; SameRegions(scores) && i < scores[0].regions.size(); ++i) {
    add(scores[0].regions[i].region + ", cut too far", scores[0].regions[i].unit,
        [&](const ScoreFigures& s) { return F(s.regions[i].over, "%.4g"); });
    if (scores.size() != 4) continue;
    const GridConvergence g = IndexOf({scores[0].regions[i].over, scores[1].regions[i].over,
                                       scores[2].regions[i].over, scores[3].regions[i].over});
    std::vector<std::string>& row = t.rows.back();
    row.push_back(F(-scores[2].regions[i].error, "%+.2g"));
    row.push_back(g.asymptotic ? F(g.order, "%.1f") : "-");
    row.push_back(g.asymptotic ? F(g.index, "%.2g") : "none: not in its range");
  }
  return t;
}

void AddOrders(SuiteContext& c) {
  auto Add = [&](std::vector<OrderRow> rows) {
    for (OrderRow& row : rows) c.findings.orders.push_back(std::move(row));
  };
  c.progress("meshes", 0, 1);
  Add(MeshOrders(c.options.quick));
  c.progress("scores on grids", 0, 1);
  Add(ScoreOrders(c.options.quick, c.options.threads));
  for (const DeviceModel& m : c.findings.models) {
    c.progress("simulated devices", 0, 1);
    Add(PlantOrders(m));
  }
  c.progress("orders", 1, 1);
}

}  // namespace

OrderRow OrderRowOf(OrderRow row, const std::vector<StepErrors>& coarse_to_fine, bool paired) {
  for (const StepErrors& at : coarse_to_fine) {
    row.steps.push_back(at.step);
    row.rms.push_back(Rms(at.errors));
  }
  const size_t last = coarse_to_fine.size() - 1;
  row.observed = OrderOf(coarse_to_fine[last - 1].errors, coarse_to_fine[last].errors, paired);
  if (!(row.observed.order >= kFalls)) row.floor = row.rms.back();
  return row;
}

void RunCuttingSuite(SuiteContext& c) {
  auto progress = [&](const std::string& what, size_t done, size_t all) {
    c.progress(what.c_str(), done, all);
  };
  CuttingPlan plan = DefaultCuttingPlan(c.options.quick);
  // Marked last: being on the front depends on the other voxel sizes.
  for (const CuttingFigures& f : MeasureCutting(plan, progress)) {
    c.findings.cutting.push_back({f, false});
  }
  MarkFront(c.findings.cutting);
  c.findings.orders = OrdersOf(c.findings.cutting);
  c.findings.tables.push_back(CuttingTable(c.findings));
  c.findings.tables.push_back(OrderTable(c.findings.orders, true));
  AddOrders(c);
  c.findings.tables.push_back(OrderTable(c.findings.orders, false));
  c.findings.tables.push_back(LimitTable());
  // Scores are of a molar at each voxel size: too long for --quick.
  if (c.options.quick) return;
  // A voxel more than the cuts have: an index needs three halvings.
  plan.voxels_nm.insert(plan.voxels_nm.begin(), 2 * plan.voxels_nm.front());
  auto scores = MeasureScores(plan.voxels_nm, kScoreTicks, progress);
  // The rest of the suite is useful without them: the table says why they are missing.
  if (!scores.ok()) {
    c.findings.tables.push_back(
        {"Scores against voxel size", "Not measured: " + scores.status().message(), {}, {}});
    return;
  }
  c.findings.scores = std::move(*scores);
  c.findings.tables.push_back(ScoreTable(c.findings.scores));
}

}  // namespace enamel::station::lab
