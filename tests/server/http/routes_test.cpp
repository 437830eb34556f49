#include "server/http/routes.h"

#include <gtest/gtest.h>

#include <set>
#include <string_view>
#include <utility>

namespace enamel::server::http {
namespace {

TEST(RoutesTest, NoOperationStandsTwice) {
  std::set<std::pair<Method, std::string_view>> seen;
  for (const Route& route : Routes()) {
    EXPECT_TRUE(seen.emplace(route.method, route.pattern).second) << route.pattern;
  }
  EXPECT_GT(seen.size(), 100u);
}

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
