#pragma once

#include <string>
#include <vector>

#include "station/lab/suites/suites.h"

// The tables of the paper suite: Liu et al. 2008, printed values beside computed ones. Private to
// suite_paper.cpp.
namespace enamel::station::lab {

// B of enamel in the paper, N s/m.
inline constexpr double kEnamel = 6500;

// What the paper prints of a device: N s/mm and N, as there.
struct Printed {
  const char* name;
  double table1_b, table1_n, table2_b, table2_eq16, table3_n;
};
// Null for other devices.
const Printed* FindPrinted(const std::string& name);

// The paper's devices in this run, with its printed values.
struct Both {
  const DeviceModel* model;
  const Printed* printed;
};
std::vector<Both> PaperDevices(const Findings& findings);

// Tables 1 and 2 (paper_limits.cpp): measured on the simulated devices, and the printed B beside
// the one that the printed K foretells.
Table MeasuredTable(SuiteContext& context);
Table ForetoldTable(SuiteContext& context);
// Table 3 (paper_table_3.cpp): sustained with each law, against itself, and by possible readings.
Table SustainedTable(SuiteContext& context);
Table ArithmeticTable(const std::vector<Both>& devices);
Table ProportionTable(SuiteContext& context, const std::vector<Both>& devices);

}  // namespace enamel::station::lab
