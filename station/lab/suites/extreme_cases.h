#pragma once

#include <vector>

#include "station/lab/suites/suites.h"

// Extreme cases that each say what must come out. Private to suite_extreme.cpp and extreme_*.cpp.
namespace enamel::station::lab {

// Bad input and sudden change: the coupling driven tick by tick, without a plant.
void AddEvents(const DeviceModel& model, std::vector<ExtremeRow>* rows);
// Ticks that come late or never, and soft structures, in four hands. The theorem does not cover them.
void AddTiming(SuiteContext& context);
// The device differs from its profile: damping b, friction c, mass, structural mode, delay, cell delta and loop rate,
// one at a time, by factors of 1/8 to 8, in four hands. Where the theorem's clause holds with the true number, the
// balance must stay above its floor; a table shows how far beyond it nothing swings.
void AddMargins(SuiteContext& context);

// The largest voxel that graded work may have with each bur (common/cutting/voxel_limit.h), cut.
void AddVoxelLimits(std::vector<ExtremeRow>* rows);

// The rows that failed, and how many passed.
Table ExtremeTable(const Findings& findings);

}  // namespace enamel::station::lab
