#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/agreement/marks.h"

// The command `agreement`: how well people who marked the same attempts agree with each other and
// with the program (schemas/marks.md). As those of admin.h.
namespace enamel::server::app {

struct AgreementOptions {
  std::vector<std::filesystem::path> marks;  // files that were filled in
  std::filesystem::path data;  // with `assignment`: computed scores as one more marker
  std::string assignment;
  std::filesystem::path blank;  // write a file to be filled in, and compare nothing
  std::filesystem::path json, csv;
};
// Errors: those of ReadFile and ReadMarks, with the file's name.
Result<std::vector<Mark>> ReadMarkFiles(const std::vector<std::filesystem::path>& files);
Status CompareAgreement(const AgreementOptions& options);

struct CommandGroup;
void DeclareAgreement(CommandGroup program);

}  // namespace enamel::server::app
