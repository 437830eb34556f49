#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/base/result.h"

// The `admin` commands about rosters, people, cohorts and sessions. Each opens the data folder
// beside a running server, or without one, prints its outcome to standard output and returns.
namespace enamel::server::app {

struct RosterCommand {
  std::filesystem::path data, file;
  bool dry_run = false;
  bool ignore_unknown_columns = false;
  std::string cohort;               // of rows without one
  std::filesystem::path passwords;  // made, mode 0600; needed when anybody is new
  std::filesystem::path json;       // the outcome (schemas/roster.md), without passwords
  std::string reading{};            // of roster::kReadings; empty: recognised
  bool move = false;                // students who join a cohort leave their other ones
};
// All or nothing. Problems with the roster are printed, all of them, and make it kInvalidInput.
Status ImportRoster(const RosterCommand& command);

struct PeopleList {
  std::filesystem::path data;
  std::string role, cohort, text;  // empty: all
  uint32_t limit = 1000;
};
Status ListPeople(const PeopleList& list);
Status ListCohorts(const std::filesystem::path& data);
Status ListSessions(const std::filesystem::path& data, const std::string& login);
Status EndSessions(const std::filesystem::path& data, const std::string& login);

struct CommandGroup;
// On the command line (command_line.h), by subject.
void DeclareRoster(CommandGroup admin);
void DeclareSessions(CommandGroup admin);

}  // namespace enamel::server::app
