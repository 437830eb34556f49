#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "server/training/roster.h"

namespace enamel::server::roster {

inline constexpr size_t kMaxRosterBytes = 1 << 20;
inline constexpr size_t kMaxRosterRows = 5000;

struct RosterOptions {
  std::string cohort;                   // of rows without one; empty: none
  bool ignore_unknown_columns = false;  // otherwise they are a problem
  std::string reading{};                // of kReadings (text_reading.h); empty: recognised
};

// A row that is none of a person: a total, a note.
struct LeftOutRow {
  uint32_t row = 0;
  std::string text;
};

struct RosterFile {
  std::string reading;          // that was taken
  std::vector<RosterRow> rows;  // those without a problem of their own
  std::vector<RosterProblem> problems;
  std::vector<std::string> ignored_columns;
  std::vector<LeftOutRow> left_out;  // below the last person
};

// Reads a roster (schemas/roster.md) and finds everything that is wrong with it by itself. Pure,
// any thread.
RosterFile ReadRoster(std::string_view bytes, const RosterOptions& options);

}  // namespace enamel::server::roster
