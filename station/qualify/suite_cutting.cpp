#include "station/qualify/suite_cutting.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>
#include <map>

#include "station/qualify/suites.h"
#include "station/qualify/svg.h"

namespace enamel::station::qualify {
namespace {

using measure::CuttingFigures;
using measure::ScoreFigures;

constexpr const char* kColours[] = {"#1f6f8b", "#c8493f", "#5b3fa0", "#b07a12",
                                    "#2e8b68", "#d1709c", "#3d5a80"};
constexpr uint64_t kScoreTicks = 60'000;

std::string F(double v, const char* format = "%.3f") {
  char text[48];
  std::snprintf(text, sizeof text, format, v);
  return text;
}

double VoxelMm(const CuttingFigures& f) { return f.c.voxel_nm * 1e-6; }

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
    t.rows.push_back({measure::BurText(c.c), F(VoxelMm(c), "%.3g"), F(c.c.speed_m_s * 1e3, "%g"),
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

// Rows at one speed, by bur, in the order measured.
std::vector<std::pair<std::string, std::vector<const CuttingRow*>>> ByBur(const Findings& f) {
  std::vector<std::pair<std::string, std::vector<const CuttingRow*>>> out;
  double speed = measure::CutCase().speed_m_s;
  for (const CuttingRow& row : f.cutting) {
    if (row.figures.c.speed_m_s != speed) continue;
    std::string name = measure::BurText(row.figures.c);
    if (out.empty() || out.back().first != name) out.push_back({name, {}});
    out.back().second.push_back(&row);
  }
  return out;
}

Plot FrontPlot(const Findings& f) {
  Plot p;
  p.title =
      "Cutting: error against run time at 5 mm/s, one line per bur, coarse to fine from left to "
      "right";
  p.x_label = "us per tick: cut, engagement, force, hash";
  p.y_label = "95th percentile distance from the swept body, um";
  p.log_x = p.log_y = true;
  p.width = 1020;
  p.height = 420;
  Series lost{"cheaper and closer elsewhere", {}, "#7d8b93", true, true};
  size_t i = 0;
  for (const auto& [name, rows] : ByBur(f)) {
    Series line{name, {}, kColours[i % std::size(kColours)]};
    Series dots{"", {}, kColours[i++ % std::size(kColours)], true};
    for (const CuttingRow* row : rows) {
      std::pair<double, double> at{row->figures.cost.mean_us, row->figures.deviation_p95_um};
      if (!row->pareto) {
        lost.points.push_back(at);
        continue;
      }
      line.points.push_back(at);
      dots.points.push_back(at);
    }
    p.series.push_back(std::move(line));
    p.series.push_back(std::move(dots));
  }
  if (!lost.points.empty()) p.series.push_back(std::move(lost));
  return p;
}

Plot VolumePlot(const Findings& f) {
  Plot p;
  p.title = "Cutting: volume error against voxel size at 5 mm/s";
  p.x_label = "voxel, mm";
  p.y_label = "error of the removed volume, %";
  p.log_x = p.log_y = true;
  p.width = 1020;
  p.height = 360;
  size_t i = 0;
  double coarsest = 0, finest = 1, worst = 0;
  for (const auto& [name, rows] : ByBur(f)) {
    Series line{name, {}, kColours[i++ % std::size(kColours)]};
    for (const CuttingRow* row : rows) {
      double percent = std::max(1e-4, 100 * std::fabs(row->figures.volume_error));
      line.points.push_back({VoxelMm(row->figures), percent});
      coarsest = std::max(coarsest, VoxelMm(row->figures));
      finest = std::min(finest, VoxelMm(row->figures));
      if (VoxelMm(row->figures) == coarsest) worst = std::max(worst, percent);
    }
    p.series.push_back(std::move(line));
  }
  if (coarsest > finest) {
    double ratio = finest / coarsest;
    p.series.push_back({"falling as h^2",
                        {{finest, worst * ratio * ratio}, {coarsest, worst}},
                        "#17242b",
                        false,
                        false,
                        true});
  }
  return p;
}

}  // namespace

void RunCuttingSuite(SuiteContext& c) {
  auto progress = [&](const std::string& what, size_t done, size_t all) {
    c.progress(what.c_str(), done, all);
  };
  measure::CuttingPlan plan = measure::DefaultCuttingPlan(c.options.quick);
  for (CuttingFigures& f : measure::MeasureCutting(plan, progress)) {
    c.findings.cutting.push_back({std::move(f), false});
  }
  MarkFront(c.findings.cutting);
  c.findings.tables.push_back(CuttingTable(c.findings));
  if (c.options.quick) return;
  auto scores = measure::MeasureScores(plan.voxels_nm, kScoreTicks, progress);
  if (!scores.ok()) {
    c.findings.tables.push_back(
        {"Scores against voxel size", "Not measured: " + scores.status().message(), {}, {}});
    return;
  }
  c.findings.scores = std::move(*scores);
  c.findings.tables.push_back(ScoreTable(c.findings.scores));
}

void AppendCuttingRows(const Findings& f, boost::json::array& rows) {
  for (const CuttingRow& row : f.cutting) {
    const CuttingFigures& c = row.figures;
    rows.push_back(boost::json::object{{"suite", "cutting"},
                                       {"bur", measure::BurText(c.c)},
                                       {"voxel_mm", VoxelMm(c)},
                                       {"speed_mm_s", c.c.speed_m_s * 1e3},
                                       {"removed_mm3", c.removed_mm3},
                                       {"analytic_mm3", c.analytic_mm3},
                                       {"volume_error", c.volume_error},
                                       {"surface_mean_um", c.deviation_mean_um},
                                       {"surface_p95_um", c.deviation_p95_um},
                                       {"surface_vertices", c.vertices},
                                       {"force_mean_n", c.force_mean_n},
                                       {"force_error", c.force_error},
                                       {"mean_us", c.cost.mean_us},
                                       {"p99_us", c.cost.p99_us},
                                       {"raw_mean_us", c.cost.raw_mean_us},
                                       {"raw_p99_us", c.cost.raw_p99_us},
                                       {"pareto", row.pareto}});
  }
  for (const ScoreFigures& s : f.scores) {
    for (const measure::CriterionFigures& criterion : s.criteria) {
      rows.push_back(boost::json::object{{"suite", "scores"},
                                         {"voxel_mm", s.voxel_nm * 1e-6},
                                         {"metric", criterion.metric},
                                         {"unit", criterion.unit},
                                         {"value", criterion.value},
                                         {"error", criterion.error},
                                         {"points", s.points},
                                         {"mb", s.mb},
                                         {"realtime_factor", s.realtime_factor}});
    }
  }
}

std::vector<std::pair<std::string, std::string>> CuttingPlots(const Findings& f) {
  if (f.cutting.empty()) return {};
  return {{"cutting-front", SvgOf(FrontPlot(f))}, {"cutting-volume", SvgOf(VolumePlot(f))}};
}

}  // namespace enamel::station::qualify
