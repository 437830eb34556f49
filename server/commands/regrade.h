#pragma once

#include <filesystem>
#include <string>

#include "common/base/result.h"

// Commands about rubrics that are corrected and cohorts that are scored again. As those of admin.h.
namespace enamel::server::app {

// The rubric that counts for the newest published version, as a document to edit. `out`: a new
// file; empty: standard output.
Status ShowRubric(const std::filesystem::path& data, const std::string& exercise,
                  const std::filesystem::path& out);

struct Correction {
  std::string exercise;  // name; its newest published version
  std::filesystem::path document;
  std::string reason;
  std::string anyway;    // why, although it is refused without
  bool preview = false;  // say what it would change, and change nothing
};
Status CorrectRubric(const std::filesystem::path& data, const Correction& correction);

struct Regrading {
  std::string cohort, exercise;  // names; no exercise: all
  bool preview = false;
};
// Queues a run for each scored attempt; the server makes them.
Status RescoreCohort(const std::filesystem::path& data, const Regrading& regrading);

struct CommandGroup;
void DeclareRubrics(CommandGroup admin);
void DeclareRescore(CommandGroup program);

}  // namespace enamel::server::app
