#include "station/lab/report/cutting_report.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>

namespace enamel::station::lab {
namespace {

// Rows at one speed, by bur, in the order measured.
std::vector<std::pair<std::string, std::vector<const CuttingRow*>>> ByBur(const Findings& f) {
  std::vector<std::pair<std::string, std::vector<const CuttingRow*>>> out;
  double speed = CutCase().speed_m_s;
  for (const CuttingRow& row : f.cutting) {
    // One speed: three would make three lines a bur, too similar to distinguish.
    if (row.figures.c.speed_m_s != speed) continue;
    std::string name = BurText(row.figures.c);
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
  Series lost{"cheaper and closer elsewhere", "muted", Style::kRings, {}};
  size_t i = 0;
  for (const auto& [name, rows] : ByBur(f)) {
    Series line{name, ColourOf(i), Style::kLine, {}};
    Series dots{"", ColourOf(i++), Style::kDots, {}};
    for (const CuttingRow* row : rows) {
      std::pair<double, double> at{row->figures.cost.mean_us, row->figures.deviation_p95_um};
      // Not on the line: it would bend back, and the line shows the possible choices.
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
  size_t i = 0;
  double coarsest = 0, finest = 1, worst = 0;
  for (const auto& [name, rows] : ByBur(f)) {
    Series line{name, ColourOf(i++), Style::kLine, {}};
    for (const CuttingRow* row : rows) {
      // The axis is logarithmic: an error of exactly 0 is drawn at the bottom, not lost.
      double percent = std::max(1e-4, 100 * std::fabs(row->figures.volume_error));
      line.points.push_back({row->figures.c.voxel_mm(), percent});
      coarsest = std::max(coarsest, row->figures.c.voxel_mm());
      finest = std::min(finest, row->figures.c.voxel_mm());
      if (row->figures.c.voxel_mm() == coarsest) worst = std::max(worst, percent);
    }
    p.series.push_back(std::move(line));
  }
  if (coarsest > finest) {
    // The slope of a second-order method, drawn through the worst bur.
    double ratio = finest / coarsest;
    p.series.push_back({"falling as h^2",
                        "reference",
                        Style::kDashes,
                        {{finest, worst * ratio * ratio}, {coarsest, worst}}});
  }
  return p;
}

}  // namespace

void AppendCuttingRows(const Findings& f, boost::json::array& rows) {
  for (const CuttingRow& row : f.cutting) {
    const CuttingFigures& c = row.figures;
    rows.push_back(boost::json::object{{"suite", "cutting"},
                                       {"bur", BurText(c.c)},
                                       {"voxel_mm", c.c.voxel_mm()},
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
    for (const CriterionFigures& criterion : s.criteria) {
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

std::vector<Plot> CuttingPlots(const Findings& f) {
  if (f.cutting.empty()) return {};
  return {FrontPlot(f), VolumePlot(f)};
}

}  // namespace enamel::station::lab
