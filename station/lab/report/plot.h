#pragma once

#include <boost/json/fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "station/lab/suites/findings.h"

// What a report draws, as the parts of schemas/lab_report.schema.json; who reads it draws it.
namespace enamel::station::lab {

enum class Style { kLine, kDashes, kDots, kRings };

struct Series {
  std::string label;  // empty: not named
  // "1" to "8", told apart; or what the series means: reference, muted, good, bad, chosen.
  std::string colour = "1";
  Style style = Style::kLine;
  std::vector<std::pair<double, double>> points = {};
  bool beside = false;  // the label beside the last point instead of in the legend
};
// The nth of the colours that are told apart, counted from 0; after the eighth they come again.
std::string ColourOf(size_t n);

struct Plot {
  std::string title = {}, x_label = {}, y_label = {};
  bool log_x = false, log_y = false;
  std::vector<Series> series = {};
};

// Of a series with more than a thousand points only as many: of each of equally many neighbours the
// lowest and the highest, so that no peak is lost. Points that no axis can show (not finite; 0 or
// less on a logarithmic one) are left out. Numbers have six digits.
boost::json::object PlotJson(const Plot& plot);
boost::json::object MapJson(const VerdictMap& map);
boost::json::object TableJson(const Table& table);

}  // namespace enamel::station::lab
