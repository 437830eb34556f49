#include "station/lab/report/cutting_report.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>

#include "common/cutting/voxel_limit.h"

namespace enamel::station::lab {
namespace {

// Rows at one speed, by bur, in the order measured.
std::vector<std::pair<std::string, std::vector<const CuttingRow*>>> ByBur(const Findings& f) {
  std::vector<std::pair<std::string, std::vector<const CuttingRow*>>> out;
  double speed = CutCase().speed_m_s;
  for (const CuttingRow& row : f.cutting) {
    // One speed: three would make three lines a bur, too similar to distinguish.
    if (row.figures.c.speed_m_s != speed || row.figures.c.plunge) continue;
    std::string name = cutting::BurText(row.figures.c.bur);
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
      std::pair<double, double> at{row->figures.cost.mean_us,
                                   row->RmsOf(&CutErrors::surface_p95_um)};
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

// Error against voxel size in a groove at one speed, with the order of the last halving beside each
// bur.
Plot OrderPlot(const Findings& f, const char* quantity, const char* what) {
  Plot p;
  p.title = std::string("Cutting: ") + what +
            " against voxel size in a groove at 5 mm/s, with the order of the last halving";
  p.x_label = "voxel, mm";
  p.log_x = p.log_y = true;
  size_t i = 0;
  for (const OrderRow& row : f.orders) {
    if (row.quantity != quantity || !row.cut || row.cut->plunge ||
        row.cut->speed_m_s != CutCase().speed_m_s)
      continue;
    p.y_label = std::string(what) + ", RMS over grids, " + row.unit;
    char order[48];
    std::snprintf(order, sizeof order, ", order %.1f", row.observed.order);
    Series line{cutting::BurText(row.cut->bur) + order, ColourOf(i++), Style::kLine, {}};
    for (size_t v = 0; v < row.rms.size(); ++v) line.points.push_back({row.steps[v], row.rms[v]});
    p.series.push_back(std::move(line));
  }
  return p;
}

boost::json::value Number(double v) {
  return std::isfinite(v) ? boost::json::value(v) : boost::json::value(nullptr);
}

}  // namespace

void AppendCuttingRows(const Findings& f, boost::json::array& rows) {
  for (const CuttingRow& row : f.cutting) {
    const CuttingFigures& c = row.figures;
    const CutErrors& first = c.grids[0];
    rows.push_back(boost::json::object{{"suite", "cutting"},
                                       {"bur", cutting::BurText(c.c.bur)},
                                       {"way", c.c.plunge ? "plunge" : "groove"},
                                       {"voxel_mm", c.c.voxel_mm()},
                                       {"speed_mm_s", c.c.speed_m_s * 1e3},
                                       {"grids", c.grids.size()},
                                       {"removed_mm3", first.removed_mm3},
                                       {"analytic_mm3", first.analytic_mm3},
                                       {"volume_error", first.volume},
                                       {"volume_rms", row.RmsOf(&CutErrors::volume)},
                                       {"surface_mean_um", row.RmsOf(&CutErrors::surface_mean_um)},
                                       {"surface_p95_um", row.RmsOf(&CutErrors::surface_p95_um)},
                                       {"surface_vertices", first.vertices},
                                       {"force_mean_n", first.force_mean_n},
                                       {"force_error", row.RmsOf(&CutErrors::force)},
                                       {"mean_us", c.cost.mean_us},
                                       {"p99_us", c.cost.p99_us},
                                       {"raw_mean_us", c.cost.raw_mean_us},
                                       {"raw_p99_us", c.cost.raw_p99_us},
                                       {"pareto", row.pareto}});
  }
  for (const OrderRow& o : f.orders) {
    boost::json::object row{
        {"suite", "order"},
        {"method", o.method},
        {"what", o.what},
        {"quantity", o.quantity},
        {"unit", o.unit},
        {"steps", boost::json::value_from(o.steps)},
        {"step_unit", o.step_unit},
        {"rms", boost::json::value_from(o.rms)},
        {"order", Number(o.observed.order)},
        {"interval", boost::json::array{Number(o.observed.low), Number(o.observed.high)}},
        {"floor", Number(o.floor)},
        {"converged_from", Number(o.converged_from)}};
    if (o.cut) {
      row["bur"] = cutting::BurText(o.cut->bur);
      row["way"] = o.cut->plunge ? "plunge" : "groove";
      row["speed_mm_s"] = o.cut->speed_m_s * 1e3;
    }
    rows.push_back(std::move(row));
  }
  for (const ScoreFigures& s : f.scores) {
    for (const RegionFigures& region : s.regions) {
      rows.push_back(boost::json::object{{"suite", "scores"},
                                         {"voxel_mm", s.voxel_nm * 1e-6},
                                         {"region", region.region},
                                         {"unit", region.unit},
                                         {"over", region.over},
                                         {"error", region.error},
                                         {"points", s.points},
                                         {"mb", s.mb},
                                         {"realtime_factor", s.realtime_factor}});
    }
  }
}

std::vector<Plot> CuttingPlots(const Findings& f) {
  if (f.cutting.empty()) return {};
  return {FrontPlot(f), OrderPlot(f, "volume", "error of the removed volume"),
          OrderPlot(f, "surface_p95", "95th percentile distance from the swept body"),
          OrderPlot(f, "force", "error of the force")};
}

}  // namespace enamel::station::lab
