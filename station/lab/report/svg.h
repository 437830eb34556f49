#pragma once

#include <string>
#include <utility>
#include <vector>

#include "station/lab/suites/findings.h"

// Plots as standalone SVG text, for files and for embedding in HTML.
namespace enamel::station::lab {

struct Series {
  std::string label;
  std::vector<std::pair<double, double>> points;
  std::string colour = "#1f6f8b";
  bool dots = false;  // marks instead of a line
  bool hollow = false;
  bool dashed = false;
  bool labelled = false;  // the label beside the last point instead of in the legend
};

struct Plot {
  std::string title, x_label, y_label;
  bool log_x = false, log_y = false;
  double width = 620, height = 340;
  std::vector<Series> series;
};

std::string SvgOf(const Plot& plot);
std::string SvgOf(const VerdictMap& map);
// Text with < > & " replaced.
std::string Escaped(const std::string& text);

}  // namespace enamel::station::lab
