#pragma once

#include <string>
#include <vector>

#include "station/lab/suites/options.h"

// Qualification of device profiles, force laws, estimators and loop rates: error against run time,
// and stability on stiff and extreme cases. Prints tables, writes JSON rows and a report to open in
// a browser (report/draw.h).
namespace enamel::station::lab {

// Runs the chosen suites. Returns a program's exit code: 0 done and no proved case violated, 1
// wrong options or a file that cannot be written (explained on errors), 2 a case that is proved
// passive was not. Blocks for minutes; uses `threads` threads. Deterministic except for ns_per_tick
// and pareto.
int RunQualify(const QualifyOptions& options);

// The names of the suites, and "all".
std::vector<std::string> SuiteNames();

}  // namespace enamel::station::lab
