#include "station/lab/report/plot.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace enamel::station::lab {
namespace {

namespace json = boost::json;
using Points = std::vector<std::pair<double, double>>;

// A plot is some hundred pixels wide.
constexpr size_t kMaxPoints = 1000;

// More digits than any plot shows; seventeen would make the document three times as long.
double SixDigits(double v) {
  char text[48];
  std::snprintf(text, sizeof text, "%.6g", v);
  return std::strtod(text, nullptr);
}

json::array Numbers(const std::vector<double>& values) {
  json::array out;
  for (double v : values) out.push_back(SixDigits(v));
  return out;
}

void AddPoints(const Points& points, json::object& out) {
  std::vector<double> x, y;
  for (auto [px, py] : points) x.push_back(px), y.push_back(py);
  out["x"] = Numbers(x);
  out["y"] = Numbers(y);
}

// Values that an axis cannot show are left out here, so that no drawer has to handle them.
Points Shown(const Points& points, bool log_x, bool log_y) {
  Points out;
  for (auto [x, y] : points) {
    if (!std::isfinite(x) || !std::isfinite(y) || (log_x && x <= 0) || (log_y && y <= 0)) continue;
    out.push_back({x, y});
  }
  return out;
}

Points Thinned(const Points& points) {
  if (points.size() <= kMaxPoints) return points;
  Points out;
  constexpr size_t kGroups = kMaxPoints / 2;
  for (size_t g = 0; g < kGroups; ++g) {
    auto from = points.begin() + static_cast<std::ptrdiff_t>(g * points.size() / kGroups),
         to = points.begin() + static_cast<std::ptrdiff_t>((g + 1) * points.size() / kGroups);
    // Lowest and highest of each group, in order, so that a thinned curve keeps its peaks.
    auto [low, high] = std::minmax_element(
        from, to, [](const auto& a, const auto& b) { return a.second < b.second; });
    out.push_back(*std::min(low, high));
    if (low != high) out.push_back(*std::max(low, high));
  }
  return out;
}

const char* StyleName(Style style) {
  switch (style) {
    case Style::kLine:
      return "line";
    case Style::kDashes:
      return "dashes";
    case Style::kDots:
      return "dots";
    case Style::kRings:
      return "rings";
  }
  return "";
}

// A suite's words for a failed condition.
bool IsBad(const std::string& cell) {
  return cell.starts_with("UNDER") || cell.starts_with("NOT BOUNDED") ||
         cell.find("VIOLATED") != std::string::npos || cell == "unstable";
}

}  // namespace

// A name instead of a colour: the page has eight distinguishable ones, in light and dark.
std::string ColourOf(size_t n) { return std::to_string(n % 8 + 1); }

json::object PlotJson(const Plot& plot) {
  json::array series;
  for (const Series& s : plot.series) {
    json::object one{{"label", s.label},
                     {"colour", s.colour},
                     {"style", StyleName(s.style)},
                     {"beside", s.beside}};
    AddPoints(Thinned(Shown(s.points, plot.log_x, plot.log_y)), one);
    series.push_back(std::move(one));
  }
  return {{"title", plot.title}, {"x_label", plot.x_label}, {"y_label", plot.y_label},
          {"log_x", plot.log_x}, {"log_y", plot.log_y},     {"series", std::move(series)}};
}

json::object MapJson(const VerdictMap& map) {
  json::array cells, curves;
  for (Verdict v : map.cells) cells.push_back(VerdictName(v));
  for (const auto& curve : map.curves) {
    json::object one{{"label", curve.label}};
    // Both axes of a map are logarithmic (VerdictMap).
    AddPoints(Shown(curve.points, true, true), one);
    curves.push_back(std::move(one));
  }
  return {{"title", map.title},        {"x_label", map.x_label},     {"y_label", map.y_label},
          {"note", map.note},          {"x", Numbers(map.x)},        {"y", Numbers(map.y)},
          {"cells", std::move(cells)}, {"curves", std::move(curves)}};
}

json::object TableJson(const Table& table) {
  auto Texts = [](const std::vector<std::string>& cells) {
    json::array out;
    for (const std::string& cell : cells) out.push_back(json::string(cell));
    return out;
  };
  json::array rows, bad;
  for (size_t r = 0; r < table.rows.size(); ++r) {
    for (size_t c = 0; c < table.rows[r].size(); ++c) {
      // Marked here, because the page would have to know every suite's words.
      if (IsBad(table.rows[r][c])) bad.push_back(json::array{r, c});
    }
    rows.push_back(Texts(table.rows[r]));
  }
  return {{"title", table.title},
          {"note", table.note},
          {"head", Texts(table.head)},
          {"rows", std::move(rows)},
          {"bad", std::move(bad)}};
}

}  // namespace enamel::station::lab
