#pragma once

#include <boost/json/fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "station/lab/suites/findings.h"

// What the suite "cutting" found, for the JSON and the report.
namespace enamel::station::lab {

// Rows with "suite": "cutting" (bur x voxel x speed) and "scores" (voxel x criterion).
void AppendCuttingRows(const Findings& findings, boost::json::array& rows);
// Named SVG plots: error against run time with its Pareto front, volume error against voxel size.
std::vector<std::pair<std::string, std::string>> CuttingPlots(const Findings& findings);

}  // namespace enamel::station::lab
