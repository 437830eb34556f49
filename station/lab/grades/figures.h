#pragma once

#include <functional>
#include <string>
#include <vector>

#include "station/lab/grades/grades.h"

// What all rows of `enamel-lab grades` come to: whether each mistake costs points as itself, is
// called by its name, and is critical where it should be. Thread safety: functions, any thread.
namespace enamel::station::lab {

struct GradeFigure {
  std::string what;  // with its goal
  std::string value;
  std::vector<std::string> misses;  // "crown-molar-46, lean 11.8 deg: 0.74 (gouge 59.7, ...)"
};

// In a fixed order. The fifth percentile of a group is the value that at most one in twenty is below.
std::vector<GradeFigure> FiguresOf(const std::vector<GradeRow>& rows);

}  // namespace enamel::station::lab
