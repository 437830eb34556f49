#include "server/http/routes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "common/base/file.h"

namespace enamel::server::http {
namespace {

// "GET /path" for every operation in the contract: its paths have indent 2, methods 4.
std::set<std::string> ContractOperations() {
  Result<Bytes> bytes = ReadFile(ENAMEL_SOURCE_DIR "/schemas/api/openapi.yaml");
  std::set<std::string> out;
  if (!bytes.ok()) return out;
  std::string_view text = AsText(*bytes);
  std::string path;
  bool in_paths = false;
  while (!text.empty()) {
    size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && line[0] != ' ') in_paths = line == "paths:";
    if (!in_paths || !line.ends_with(':')) continue;
    if (line.starts_with("  /")) path = line.substr(2, line.size() - 3);
    for (const char* method : {"get", "post", "put", "patch", "delete"}) {
      if (line != "    " + std::string(method) + ":") continue;
      std::string upper(method);
      std::transform(upper.begin(), upper.end(), upper.begin(),
                     [](unsigned char c) { return std::toupper(c); });
      out.insert(upper + " " + path);
    }
  }
  return out;
}

std::set<std::string> TableOperations() {
  std::set<std::string> out;
  for (const Route& route : Routes()) {
    out.insert(std::string(MethodName(route.method)) + " " + std::string(route.pattern));
  }
  return out;
}

TEST(RoutesTest, TableAndContractNameTheSameOperations) {
  std::set<std::string> contract = ContractOperations();
  ASSERT_GT(contract.size(), 10u);
  EXPECT_EQ(TableOperations(), contract);
}

TEST(RoutesTest, NoOperationStandsTwice) { EXPECT_EQ(TableOperations().size(), Routes().size()); }

TEST(RoutesTest, MatchesTheIdAndNothingBeyondIt) {
  RouteMatch match = FindRoute(Method::kGet, "/api/v1/attempts/abc/score");
  ASSERT_TRUE(match.route);
  EXPECT_EQ(match.route->pattern, "/api/v1/attempts/{id}/score");
  EXPECT_EQ(match.id, "abc");
  EXPECT_FALSE(FindRoute(Method::kGet, "/api/v1/attempts/a/b/score").route);
  EXPECT_FALSE(FindRoute(Method::kGet, "/api/v1/attempts/").route);
  EXPECT_FALSE(FindRoute(Method::kGet, "/api/v1/attempts//score").route);
}

TEST(RoutesTest, NamesTheAllowedMethodsOfAKnownPath) {
  RouteMatch match = FindRoute(Method::kOther, "/api/v1/session");
  EXPECT_FALSE(match.route);
  EXPECT_EQ(match.allowed_methods, "POST, GET, HEAD, DELETE");
  EXPECT_TRUE(FindRoute(Method::kHead, "/api/v1/session").route);
}

}  // namespace
}  // namespace enamel::server::http
