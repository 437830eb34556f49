#include "server/http/etag.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <map>

#include "server/auth/throttle.h"
#include "server/http/error_response.h"
#include "server/http/paging.h"
#include "server/training/revision.h"

namespace enamel::server::http {
namespace {

Request With(const std::string& if_match) {
  Request request;
  request.headers["if-match"] = if_match;
  return request;
}

TEST(ETagTest, WhatWasGivenComesBackAsTheRevision) {
  for (int32_t revision : {1, 7, 2147483647}) {
    Response response = WithETag({}, revision);
    ASSERT_EQ(response.headers.back().first, "ETag");
    EXPECT_EQ(*IfMatch(With(response.headers.back().second)), revision);
  }
}

TEST(ETagTest, AProxyThatCompressesLeavesTheRevision) {
  for (const char* tag :
       {"W/\"7\"", "\"7-gzip\"", "\"7-br\"", "\"7-zstd\"", "\"7-deflate\"", "W/\"7-gzip\""}) {
    const auto revision = IfMatch(With(tag));
    ASSERT_TRUE(revision.ok()) << tag << ": " << revision.status().message();
    EXPECT_EQ(*revision, 7) << tag;
  }
}

TEST(ETagTest, WhatIsNoETagOfOursIsRefusedWithWhatWasFound) {
  for (const char* text :
       {"*", "7", "\"\"", "\"x\"", "\"07\"", "\"-1\"", "W/7", "w/\"7\"", "\"7-\"", "\"7-x\"",
        "\"-gzip\"", "\"2147483648\"", "\"7\", \"8\"", "\"0\""}) {
    Status refused = IfMatch(With(text)).status();
    EXPECT_EQ(ErrorResponse(refused).status, 428) << text;
    EXPECT_NE(refused.message().find(std::string("found ") + text), std::string::npos) << text;
  }
}

TEST(ETagTest, EditWithoutOneIsRefusedAs428AndAStaleOneAs412WithWhatIsThereNow) {
  Response missing = ErrorResponse(IfMatch(Request{}).status());
  EXPECT_EQ(missing.status, 428);
  EXPECT_NE(missing.body.find("\"precondition_required\""), std::string::npos) << missing.body;
  Status changed{Code::kConflict, "somebody else renamed it", std::string(kStale)};
  Response stale = Stale(changed, {{"name", "now"}}, 8);
  EXPECT_EQ(stale.status, 412);
  EXPECT_EQ(boost::json::parse(stale.body).at("current").at("name"), "now");
  EXPECT_EQ(stale.headers.back().second, "\"8\"");
  EXPECT_EQ(ErrorResponse(changed).status, 412);
}

TEST(ErrorResponseTest, WhatThePeerWroteInOtherBytesComesBackAsJson) {
  Response response = ErrorResponse(421, "misdirected", "found \xff\xfe", "h\xf6st");
  auto error = boost::json::parse(response.body).at("error");
  EXPECT_EQ(error.at("message").as_string(), "found \ufffd\ufffd");
  EXPECT_EQ(error.at("field").as_string(), "h\ufffdst");
}

TEST(ErrorResponseTest, ThrottledSignInIsToldItsOwnTime) {
  Response response = ErrorResponse(auth::Throttled(11'500));
  EXPECT_EQ(response.status, 429);
  EXPECT_EQ(response.headers.back().second, "12");
  EXPECT_EQ(ErrorResponse(Status{Code::kUnavailable, "busy"}).headers.back().second, "5");
}

std::vector<std::string> Walk(std::vector<std::string> rows, uint32_t limit) {
  std::vector<std::string> seen;
  Page page{limit, {}};
  for (int i = 0; i < 100; ++i) {
    std::vector<std::string> cut = rows;
    boost::json::value next = CutPage(cut, page, [](const std::string& row) { return row; });
    EXPECT_LE(cut.size(), limit);
    seen.insert(seen.end(), cut.begin(), cut.end());
    if (next.is_null()) return seen;
    Request request;
    request.query = {{"limit", std::to_string(limit)}, {"cursor", std::string(next.as_string())}};
    page = *PageOf(request, 50, 200);
    // What comes before the cursor meanwhile is not shown twice and pushes nothing out.
    rows.insert(rows.begin(), "a" + std::to_string(i));
  }
  return seen;
}

TEST(PagingTest, PagesFollowEachOtherWithoutGapOrRepeat) {
  const std::vector<std::string> rows = {"b", "c", "d", "e\xff", "f"};
  for (uint32_t limit : {1u, 2u, 4u, 5u, 6u}) EXPECT_EQ(Walk(rows, limit), rows) << limit;
}

TEST(PagingTest, CursorsAndLimitsThatWereNotGivenAreRefusedByName) {
  for (const auto& [name, value] :
       std::multimap<std::string, std::string>{{"cursor", ""},
                                               {"cursor", "zz"},
                                               {"cursor", "abc"},
                                               {"cursor", std::string(2000, 'a')},
                                               {"limit", "0"},
                                               {"limit", "201"},
                                               {"limit", "x"}}) {
    Request request;
    request.query[name] = value;
    Result<Page> page = PageOf(request, 50, 200);
    ASSERT_FALSE(page.ok()) << name << "=" << value.substr(0, 10);
    EXPECT_EQ(page.status().field(), name);
  }
}

}  // namespace
}  // namespace enamel::server::http
