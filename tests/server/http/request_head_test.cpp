#include "server/http/request_head.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/file.h"
#include "tests/server/http/desync_suite.h"

namespace enamel::server::http {
namespace {

std::string Get(const std::string& headers) {
  return "GET /a?b=c HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n";
}
std::string Post(const std::string& headers) {
  return "POST /a HTTP/1.1\r\nHost: localhost\r\n" + headers + "\r\n";
}

TEST(RequestHeadTest, AcceptsWhatBrowsersSend) {
  EXPECT_TRUE(CheckRequestHead(Get("Accept: */*\r\nCookie: a=b; c=d\r\nX-Empty:\r\n")).ok());
  EXPECT_TRUE(CheckRequestHead(Get("Content-Length: 0\r\n")).ok());
  EXPECT_TRUE(
      CheckRequestHead(Post("Content-Length: 12\r\nContent-Type: application/json\r\n")).ok());
  EXPECT_TRUE(CheckRequestHead(Post("Transfer-Encoding: Chunked\r\n")).ok());
  EXPECT_TRUE(CheckRequestHead(Post("X: \t\xc3\xa4 \r\n")).ok());
}

TEST(RequestHeadTest, RefusesWhatTwoReadersCouldCutDifferently) {
  const std::string heads[] = {
      Post("Content-Length: 1\r\nContent-Length: 1\r\n"),
      Post("Content-Length: 1\r\nTransfer-Encoding: chunked\r\n"),
      Post("Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n"),
      Post("Transfer-Encoding: gzip, chunked\r\n"),
      Post("Content-Length: +1\r\n"),
      Post("Content-Length: 0x1\r\n"),
      Post("Content-Length: -1\r\n"),
      Post("Content-Length:\r\n"),
      Post("Content-Length: 1, 1\r\n"),
      Post("Content-Length: 9999999999999999999999\r\n"),
      Post("Content-Length : 1\r\n"),
      Post("Content_Length: 1\r\n"),
      Post("X: a\r\n b\r\n"),
      Post("X: a\nY: b\r\n"),
      Post("X: a\rY: b\r\n"),
      Post(std::string("X: a\0b\r\n", 8)),
      Post(" X: a\r\n"),
      Post(": a\r\n"),
      Post("X\r\n"),
      Post("Host: other\r\n"),
      Get("Content-Length: 1\r\n"),
      Get("Transfer-Encoding: chunked\r\n"),
      "GET /a HTTP/1.1\r\n\r\n",
      "GET /a HTTP/1.0\r\nHost: localhost\r\n\r\n",
      "GET /a\r\nHost: localhost\r\n\r\n",
      "GET  /a HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET /a b HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET /a\t HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET /a#b HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET http://localhost/a HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "OPTIONS * HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "CONNECT localhost:80 HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "\r\nGET /a HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "G\x01T /a HTTP/1.1\r\nHost: localhost\r\n\r\n",
  };
  for (const std::string& head : heads) {
    Status status = CheckRequestHead(head);
    EXPECT_EQ(status.code(), Code::kInvalidInput) << head;
    EXPECT_FALSE(status.message().empty());
  }
}

TEST(RequestHeadTest, FindsTheEndWhereverTheHeadIsSplit) {
  const std::string head = Get("Accept: */*\r\n");
  const std::string bytes = head + "body";
  for (size_t split = 0; split <= head.size(); ++split) {
    size_t first = FindHeadEnd(std::string_view(bytes).substr(0, split));
    EXPECT_EQ(first, split == head.size() ? head.size() : std::string_view::npos) << split;
    EXPECT_EQ(FindHeadEnd(bytes, split == head.size() ? 0 : split), head.size()) << split;
  }
}

TEST(RequestHeadTest, EndsAtTheFirstEmptyLineHoweverItIsSpelt) {
  EXPECT_EQ(FindHeadEnd("GET / HTTP/1.1\n\nX"), 16u);
  EXPECT_EQ(FindHeadEnd("GET / HTTP/1.1\n\r\nX"), 17u);
  EXPECT_EQ(FindHeadEnd(std::string_view("\x16\x03\x01", 3)), 1u);  // a TLS hello on a plain port
}

std::vector<DesyncCase> SuiteCases() {
  std::vector<DesyncCase> out;
  std::filesystem::path folder =
      std::filesystem::path(ENAMEL_SHARED_DATA) / "suites/http_desync_guardian/tests";
  if (!std::filesystem::exists(folder)) return out;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".yaml") continue;
    Result<Bytes> text = ReadFile(entry.path(), 1 << 20);
    if (!text.ok()) continue;
    for (DesyncCase& found : ReadDesyncCases(AsText(*text))) out.push_back(std::move(found));
  }
  return out;
}

TEST(RequestHeadTest, AcceptsNothingThatTheDesyncSuiteCallsAmbiguousOrSevere) {
  std::vector<DesyncCase> cases = SuiteCases();
  if (cases.empty()) GTEST_SKIP() << "skipped: no shared data";
  size_t dangerous = 0, compliant = 0, accepted = 0;
  for (const DesyncCase& suspect : cases) {
    bool ok = CheckRequestHead(suspect.Head()).ok();
    ASSERT_FALSE(suspect.tier.empty()) << suspect.name;
    if (suspect.tier == "Ambiguous" || suspect.tier == "Severe") {
      ++dangerous;
      EXPECT_FALSE(ok) << suspect.name << "\n" << suspect.Head();
    } else if (suspect.tier == "Compliant") {
      ++compliant;
      accepted += ok;
      if (!ok) std::printf("stricter than the suite: %s\n", suspect.name.c_str());
    }
  }
  EXPECT_GT(dangerous, 0u);
  std::printf("dangerous %zu, all refused; compliant %zu, accepted %zu\n", dangerous, compliant,
              accepted);
}

}  // namespace
}  // namespace enamel::server::http
