#include "common/program/findings.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>

#include "common/base/counted.h"
#include "common/base/utf8.h"
#include "common/program/output.h"

namespace enamel::program {
namespace {

const char* Word(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kWarn:
      return "warn";
    case Verdict::kFail:
      return "fail";
  }
  return "";
}

auto Failed(const std::vector<Finding>& findings) {
  return std::ranges::count(findings, Verdict::kFail, &Finding::verdict);
}

}  // namespace

boost::json::object FindingsJson(const std::vector<Finding>& findings) {
  boost::json::array all;
  for (const Finding& f : findings) {
    all.push_back(
        {{"what", f.what}, {"verdict", Word(f.verdict)}, {"found", f.found}, {"advice", f.advice}});
  }
  return {{"findings", std::move(all)}, {"failed", Failed(findings)}};
}

Status Report(const std::vector<Finding>& findings, const std::filesystem::path& json,
              const std::string& missing) {
  for (const Finding& f : findings) {
    std::printf("%-5s %-17s %s%s%s\n", Word(f.verdict), f.what.c_str(),
                std::string(Printable(f.found)).c_str(), f.advice.empty() ? "" : ": ",
                std::string(Printable(f.advice)).c_str());
  }
  ENAMEL_RETURN_IF_ERROR(WriteJsonFile(json, FindingsJson(findings)));
  const auto failed = static_cast<size_t>(Failed(findings));
  if (failed == 0) return Status::Ok();
  return Status(Code::kUnavailable,
                Counted(failed, "thing is ", "things are ") + missing + ": see 'fail' above");
}

}  // namespace enamel::program
