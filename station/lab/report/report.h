#pragma once

#include <boost/json/fwd.hpp>
#include <string>

#include "station/lab/suites/findings.h"

// The suites' findings, as text tables and as JSON.
namespace enamel::station::lab {

std::string TextOf(const Table& table);
// The drawn part: schemas/lab_report.schema.json.
boost::json::object ReportOf(const Findings& findings);
// A point of the joint front, as rows of `qualify --suite front` and `explain --json` have it.
boost::json::object JointPointJson(const JointPoint& point);
// schemas/feel.schema.json.
boost::json::object FeelJson(const std::vector<FeelCurve>& curves);
// {"format": 1, "seed", "quick", "rows": [...], "attacks": [...], "random": {...}, "report": {...}}
std::string JsonOf(const Findings& findings);

}  // namespace enamel::station::lab
