#include "server/http/wire/request_head.h"

#include <gtest/gtest.h>

#include <string>

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

TEST(RequestHeadTest, AcceptsTheOtherFormsOfATarget) {
  for (const char* line :
       {"GET http://localhost/a?b=c HTTP/1.1", "GET HTTPS://LOCALHOST HTTP/1.1",
        "OPTIONS * HTTP/1.1", "GET /a HTTP/1.0", "GET /\xc3\xa4?b=[c]#d HTTP/1.1"}) {
    EXPECT_TRUE(CheckRequestHead(std::string(line) + "\r\nHost: localhost\r\n\r\n").ok()) << line;
  }
}

TEST(RequestHeadTest, SaysWhatIsWellFormedAndNotSpokenHere) {
  const std::pair<std::string, const char*> heads[] = {
      {"GET /a HTTP/1.2\r\nHost: localhost\r\n\r\n", "request line"},
      {"GET /a HTTP/2.0\r\nHost: localhost\r\n\r\n", "request line"},
      {Post("Transfer-Encoding: gzip, chunked\r\n"), "transfer-encoding"},
      {Post("Transfer-Encoding: gzip\r\nTransfer-Encoding: chunked\r\n"), "transfer-encoding"},
      {Post("Content-Encoding: gzip\r\nContent-Length: 9\r\n"), "content-encoding"},
  };
  for (const auto& [head, field] : heads) {
    Status status = CheckRequestHead(head);
    EXPECT_EQ(status.code(), Code::kVersion) << head;
    EXPECT_EQ(status.field(), field) << head;
  }
}

TEST(RequestHeadTest, RefusesWhatTwoReadersCouldCutDifferently) {
  const std::string heads[] = {
      Post("Content-Length: 1\r\nContent-Length: 1\r\n"),
      Post("Content-Length: 1\r\nTransfer-Encoding: chunked\r\n"),
      Post("Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n"),
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
      "GET /a\r\nHost: localhost\r\n\r\n",
      "GET  /a HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET /a b HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET /a\t HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET http://other/a HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET http:///a HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET ftp://localhost/a HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET * HTTP/1.1\r\nHost: localhost\r\n\r\n",
      "GET /a HTTP/1.0\r\n\r\n",
      "GET /a HTTP/0.9\r\nHost: localhost\r\n\r\n",
      "GET /a HTTP/1.10\r\nHost: localhost\r\n\r\n",
      "GET /a http/1.1\r\nHost: localhost\r\n\r\n",
      "POST /a HTTP/1.0\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n",
      Post("Transfer-Encoding: gzip\r\n"),
      Post("Transfer-Encoding: chunked, gzip\r\n"),
      Post("Transfer-Encoding: chunked, chunked\r\n"),
      Post("Transfer-Encoding: ,chunked\r\n"),
      Post("Transfer-Encoding: chunked;a=b\r\n"),
      Post("Transfer-Encoding: \"chunked\"\r\n"),
      Post("Transfer-Encoding: xchunked\r\n"),
      Post("Transfer-Encoding: gzip\r\nContent-Length: 3\r\n"),
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

}  // namespace
}  // namespace enamel::server::http
