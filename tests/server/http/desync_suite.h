#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

// Reads the test cases of the http-desync-guardian suite: the few forms of YAML they are written in
// (a list of maps, one nested list, plain, 'single' and "double" quoted scalars with \x escapes).
namespace enamel::server::http {

struct DesyncCase {
  std::string name, uri, method, version;
  std::vector<std::pair<std::string, std::string>> headers;
  std::string tier;    // Compliant, Acceptable, Ambiguous, Severe
  std::string reason;  // NonCompliantHeader, BadUri, …

  // Request line and headers as the case says, with a Host in front unless it has its own.
  std::string Head() const;
};

std::vector<DesyncCase> ReadDesyncCases(std::string_view yaml);

// Every case of the suite's files, in the order of their names; none without shared data.
std::vector<DesyncCase> SharedDesyncCases();

}  // namespace enamel::server::http
