#pragma once

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
};

struct RosterFile {
  std::vector<RosterRow> rows;  // those without a problem of their own
  std::vector<RosterProblem> problems;
  std::vector<std::string> ignored_columns;
};

// Reads a roster (schemas/roster.md) and finds everything that is wrong with it by itself. Pure,
// any thread.
RosterFile ReadRoster(std::string_view text, const RosterOptions& options);

}  // namespace enamel::server::roster
