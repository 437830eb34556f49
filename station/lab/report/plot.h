#pragma once

#include <boost/json/fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "station/lab/suites/findings.h"

// Contents of a report's drawings, in the parts of schemas/lab_report.schema.json; the reader of
// the document draws them.
namespace enamel::station::lab {

enum class Style { kLine, kDashes, kDots, kRings };

struct Series {
  std::string label;  // empty: none
  // "1" to "8", eight distinguishable colours; or by meaning: reference, muted, good, bad, chosen.
  std::string colour = "1";
  Style style = Style::kLine;
  std::vector<std::pair<double, double>> points = {};
  bool beside = false;  // the label beside the last point instead of in the legend
};
// The nth distinguishable colour, counted from 0; after the eighth they repeat.
std::string ColourOf(size_t n);

struct Plot {
  std::string title = {}, x_label = {}, y_label = {};
  bool log_x = false, log_y = false;
  std::vector<Series> series = {};
};

// A series with more than a thousand points is thinned to that: the lowest and the highest of
// equally many neighbours, so that no peak is lost. Points that no axis can show (not finite; 0 or
// less on a logarithmic one) are left out. Numbers have six digits.
boost::json::object PlotJson(const Plot& plot);
boost::json::object MapJson(const VerdictMap& map);
boost::json::object TableJson(const Table& table);

}  // namespace enamel::station::lab
