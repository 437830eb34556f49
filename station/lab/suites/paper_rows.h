#pragma once

#include <vector>

#include "station/lab/suites/paper_elements.h"

// The parts of PaperElements, in the paper's order. Private to paper_*.cpp.
namespace enamel::station::lab {

std::vector<PaperElement> PaperEquations(const PrintedPaper& printed,
                                         const std::vector<DeviceModel>& devices);
// The measured cutting, tables 1 to 3 and figures 7 to 9.
std::vector<PaperElement> PaperExperiments(const PrintedPaper& printed,
                                           const std::vector<DeviceModel>& devices);

// Whether `ours`, rounded as `printed` is to a figure in `unit`, is what is printed.
bool SameFigure(double printed, double ours, double unit);

}  // namespace enamel::station::lab
