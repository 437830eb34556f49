#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/results/result_document.h"

// A signed result outside the house: the files that it binds, by their names in a folder, and their
// check without a server (schemas/result.md, "Files"). Thread safety: functions, any thread.
namespace enamel::server {

inline constexpr std::string_view kResultFile = "result.bin";

struct ResultFile {
  std::string name;
  Bytes content;

  bool operator==(const ResultFile&) const = default;
};

// The files that a result binds, in the order in which the programs report them: score.json first.
std::vector<std::string_view> BoundFileNames();

struct ResultCheck {
  std::vector<std::string> as_signed;
  std::vector<std::string> not_there;  // bound by the result, and not among the files
  std::vector<std::string> changed;    // a sentence each, beginning with the name
};
// Requires: VerifyResult(document). Files of other names are passed over.
ResultCheck CheckResultFiles(const ResultDocument& document, const std::vector<ResultFile>& files);

}  // namespace enamel::server
