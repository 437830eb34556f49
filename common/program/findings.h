#pragma once

#include <boost/json/fwd.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/base/result.h"

// What a `doctor` finds, and how it says it.
namespace enamel::program {

enum class Verdict : uint8_t { kOk, kWarn, kFail };

// One requirement, and whether it is met here.
struct Finding {
  std::string what;  // "real-time rights"
  Verdict verdict = Verdict::kOk;
  std::string found;
  std::string advice;  // what to do; empty if all is well
};

// {"findings": [{"what", "verdict": "ok", "warn" or "fail", "found", "advice"}], "failed": number}
boost::json::object FindingsJson(const std::vector<Finding>& findings);

// Prints them, one a line, and writes FindingsJson to `json` unless that is empty. Errors:
// kUnavailable if one failed (warnings are no error), "N things are " + `missing`; kStorage.
Status Report(const std::vector<Finding>& findings, const std::filesystem::path& json,
              const std::string& missing);

}  // namespace enamel::program
