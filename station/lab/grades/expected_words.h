#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "station/lab/grades/grades.h"

// What an instructor would call each known fault, and what to do about it. Written down from the
// faults, not from what the score says of them. Thread safety: functions, any thread.
namespace enamel::station::lab {

// Codes of remedies.h, each of them right. A critical error is called by its own code.
struct ExpectedWords {
  std::vector<std::string_view> exercises;  // beginnings of their names; empty: any
  std::string_view fault;                   // beginning of its name
  int sign = 0;                             // of the fault's size; 0: any
  std::vector<std::string_view> faults, remedies;
};

// nullptr where nothing has to be said: less than a point was lost.
const ExpectedWords* ExpectedWordsOf(const GradeRow& row);

}  // namespace enamel::station::lab
