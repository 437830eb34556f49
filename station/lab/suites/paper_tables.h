#pragma once

#include <string>
#include <vector>

#include "station/lab/suites/paper_elements.h"
#include "station/lab/suites/suites.h"

// The tables of the paper suite: Liu et al. 2008, printed values beside computed ones. Private to
// suite_paper.cpp.
namespace enamel::station::lab {

// B of enamel in the paper, N s/m.
inline constexpr double kEnamel = 6500;

// The numbers that the paper prints (paper_elements.h).
const PrintedPaper& ThePaper();
// Null for devices that the paper does not have.
const PrintedDevice* FindPrinted(const std::string& name);

// The paper's devices in this run, with its printed values.
struct Both {
  const DeviceModel* model;
  const PrintedDevice* printed;
};
std::vector<Both> PaperDevices(const Findings& findings);

// Every element of the paper beside ours.
Table ElementsTable();
// Tables 1 and 2, measured on the simulated devices (paper_limits.cpp).
Table MeasuredTable(SuiteContext& context);
// Table 3 (paper_table_3.cpp): sustained with each law, against itself, and by possible readings.
Table SustainedTable(SuiteContext& context);
Table ArithmeticTable(const std::vector<Both>& devices);
Table ProportionTable(SuiteContext& context, const std::vector<Both>& devices);

}  // namespace enamel::station::lab
