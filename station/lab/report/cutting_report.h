#pragma once

#include <boost/json/fwd.hpp>
#include <vector>

#include "station/lab/report/plot.h"

// Findings of the suite "cutting", for the JSON and the report.
namespace enamel::station::lab {

// Rows with "suite": "cutting" (bur x voxel x speed) and "scores" (voxel x region).
void AppendCuttingRows(const Findings& findings, boost::json::array& rows);
// Error against run time with its Pareto front, volume error against voxel size.
std::vector<Plot> CuttingPlots(const Findings& findings);

}  // namespace enamel::station::lab
