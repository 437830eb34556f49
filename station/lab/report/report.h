#pragma once

#include <string>

#include "common/base/result.h"
#include "station/lab/suites/findings.h"

// What the suites found, as text tables, JSON rows, SVG plots and one self-contained HTML page.
namespace enamel::station::lab {

std::string TextOf(const Table& table);
// {"format": 1, "seed", "quick", "rows": [...], "attacks": [...], "random": {...}}
std::string JsonOf(const Findings& findings);
// Named plots, in the order of the page: file name without extension, SVG text.
std::vector<std::pair<std::string, std::string>> PlotsOf(const Findings& findings);
std::string HtmlOf(const Findings& findings);
// Writes report.html, plots and qualification.json into `folder`, making it. Errors: kStorage.
Status WriteReport(const Findings& findings, const std::string& folder);

}  // namespace enamel::station::lab
