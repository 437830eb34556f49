#include <algorithm>

#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

// A minute at 1 kHz, over which the hand spreads its strokes (cutting/attempt.cpp).
constexpr uint64_t kScoreTicks = 60'000;

bool SameCut(const CuttingFigures& a, const CuttingFigures& b) {
  return a.c.bur == b.c.bur && a.c.speed_m_s == b.c.speed_m_s;
}

// On the front: no other voxel size of the same bur and speed is both cheaper and more exact.
void MarkFront(std::vector<CuttingRow>& rows) {
  for (CuttingRow& row : rows) {
    row.pareto = std::none_of(rows.begin(), rows.end(), [&](const CuttingRow& other) {
      const CuttingFigures &a = other.figures, &b = row.figures;
      bool no_worse = a.cost.mean_us <= b.cost.mean_us && a.deviation_p95_um <= b.deviation_p95_um;
      bool better = a.cost.mean_us < b.cost.mean_us || a.deviation_p95_um < b.deviation_p95_um;
      // Another bur or speed is another task, not a cheaper way to do this one.
      return SameCut(a, b) && no_worse && better;
    });
  }
}

Table CuttingTable(const Findings& f) {
  Table t;
  t.title = "Cutting against swept bodies: voxel size, bur, speed";
  t.head = {"bur",
            "voxel mm",
            "mm/s",
            "removed mm3",
            "volume error %",
            "surface mean um",
            "surface p95 um",
            "force N",
            "force error %",
            "us a tick",
            "p99 us",
            "front"};
  t.note =
      "A slot half the bur's height deep, block and bur turned off the grid together. Volume "
      "against the closed form; "
      "surface: the slot's mesh against the swept body, rims included; force against the finest "
      "voxel; "
      "microseconds: per tick the least of several identical replays. Front: no other voxel size "
      "of this bur and speed is "
      "both cheaper and closer to the body (p95).";
  for (const CuttingRow& row : f.cutting) {
    const CuttingFigures& c = row.figures;
    t.rows.push_back({BurText(c.c), F(c.c.voxel_mm(), "%.3g"), F(c.c.speed_m_s * 1e3, "%g"),
                      F(c.removed_mm3), F(100 * c.volume_error, "%+.3f"),
                      F(c.deviation_mean_um, "%.2f"), F(c.deviation_p95_um, "%.2f"),
                      F(c.force_mean_n), F(100 * c.force_error, "%.2f"), F(c.cost.mean_us, "%.1f"),
                      F(c.cost.p99_us, "%.1f"), row.pareto ? "yes" : ""});
  }
  return t;
}

Table ScoreTable(const std::vector<ScoreFigures>& scores) {
  Table t;
  t.title =
      "Scores against voxel size: the same hand, mesial wall 0.3 mm and floor 0.15 mm too deep";
  t.note =
      "A class I cavity in the built-in molar, compared with the same hand's exact cut at the same "
      "voxel size. In brackets: "
      "error against the finest voxel.";
  t.head = {"figure", "unit"};
  for (const ScoreFigures& s : scores) t.head.push_back(F(s.voxel_nm * 1e-6, "%g") + " mm");
  auto add = [&](const std::string& name, const std::string& unit, auto&& value) {
    std::vector<std::string> row{name, unit};
    for (const ScoreFigures& s : scores) row.push_back(value(s));
    t.rows.push_back(std::move(row));
  };
  add("whole tooth", "MB", [](const ScoreFigures& s) { return F(s.mb, "%.1f"); });
  add("replay", "x real time", [](const ScoreFigures& s) { return F(s.realtime_factor, "%.0f"); });
  add("score", "points", [](const ScoreFigures& s) { return F(s.points, "%.2f"); });
  for (size_t i = 0; !scores.empty() && i < scores[0].criteria.size(); ++i) {
    add(scores[0].criteria[i].metric, scores[0].criteria[i].unit, [&](const ScoreFigures& s) {
      return F(s.criteria[i].value, "%.4g") + " (" + F(s.criteria[i].error, "%+.2g") + ")";
    });
  }
  return t;
}

}  // namespace

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
  c.findings.tables.push_back(CuttingTable(c.findings));
  // Scores are of a molar at each voxel size: too long for --quick.
  if (c.options.quick) return;
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
