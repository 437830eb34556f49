#include "server/http/wire/request_reader.h"

#include <gtest/gtest.h>

#include <string>

namespace enamel::server::http {
namespace {

using Step = RequestReader::Step;

const std::string kChunkedPost =
    "POST /a%20b?c=d&e=%C3%A4 HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n"
    "Cookie: a=b\r\nCookie: c=d\r\nX: 1\r\nX: 2\r\n\r\n5;x=y\r\nhello\r\n6\r\n world\r\n0\r\n\r\n";

// In pieces of `piece` bytes, keeping unused ones; returns how many were used in the end.
Step FeedIn(RequestReader& reader, const std::string& bytes, size_t piece, size_t& total) {
  std::string unused;
  total = 0;
  Step step = Step::kMore;
  for (size_t at = 0; at < bytes.size() && step != Step::kRequest && step != Step::kRefused;
       at += piece) {
    unused += bytes.substr(at, piece);
    size_t used = 0;
    step = reader.Feed(unused, used);
    unused.erase(0, used);
    total += used;
  }
  return step;
}

TEST(RequestReaderTest, FindsTheSameRequestInWhateverPiecesItArrives) {
  for (size_t piece = 1; piece <= kChunkedPost.size(); ++piece) {
    RequestReader reader;
    size_t total = 0;
    ASSERT_EQ(FeedIn(reader, kChunkedPost, piece, total), Step::kRequest) << piece;
    EXPECT_EQ(total, kChunkedPost.size());
    EXPECT_EQ(reader.request().body, "hello world");
    EXPECT_EQ(reader.request().path, "/a%20b");
    EXPECT_EQ(reader.request().query["e"], "\xc3\xa4");
    EXPECT_EQ(reader.request().headers["cookie"], "a=b; c=d");
    EXPECT_EQ(reader.request().headers["x"], "1, 2");
    EXPECT_TRUE(reader.keep_alive());
  }
}

TEST(RequestReaderTest, AnotherProtocolIsNamedWithWhatToDo) {
  const std::string kRequest = "GET /readyz HTTP/1.1\r\nHost: a\r\n\r\n";
  const std::pair<std::string, const char*> kOthers[] = {
      {std::string("\x16\x03\x01\0\xa5\x01", 6) + std::string(160, 'a'), "found TLS"},
      {"PROXY TCP4 192.0.2.7 192.0.2.8 51234 443\r\n" + kRequest, "found the PROXY protocol"},
      {std::string("\r\n\r\n\0\r\nQUIT\n\x21\x11\0\x0c", 16) + kRequest,
       "found the PROXY protocol"},
      {"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", "found HTTP/2"}};
  for (const auto& [bytes, what] : kOthers) {
    // Version 2 of the PROXY protocol begins with an empty head: only its first bytes together tell.
    for (const size_t piece : {bytes.size(), bytes[0] == '\r' ? size_t{12} : size_t{3}}) {
      RequestReader reader;
      size_t total = 0;
      ASSERT_EQ(FeedIn(reader, bytes, piece, total), Step::kRefused) << what;
      EXPECT_NE(reader.refusal().body.find(what), std::string::npos) << reader.refusal().body;
    }
  }
}

TEST(RequestReaderTest, LeavesTheNextRequestAlone) {
  RequestReader reader;
  size_t used = 0;
  EXPECT_EQ(reader.Feed(kChunkedPost + "GET / HTTP/1.1\r\n", used), Step::kRequest);
  EXPECT_EQ(used, kChunkedPost.size());
}

TEST(RequestReaderTest, AsksToContinueOnceAndOnlyWhenTheBodyIsNotThere) {
  const std::string head =
      "POST / HTTP/1.1\r\nHost: localhost\r\nExpect: 100-continue\r\nContent-Length: 2\r\n\r\n";
  RequestReader waiting;
  size_t used = 0;
  EXPECT_EQ(waiting.Feed(head, used), Step::kContinue);
  EXPECT_EQ(waiting.Feed("", used), Step::kMore);
  EXPECT_EQ(waiting.Feed("{}", used), Step::kRequest);
  RequestReader eager;
  EXPECT_EQ(eager.Feed(head + "{}", used), Step::kRequest);
}

TEST(RequestReaderTest, AnEndlessBodyOfTinyChunksEnds) {
  RequestReader reader;
  size_t used = 0;
  ASSERT_EQ(reader.Feed("POST / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n", used),
            Step::kMore);
  const std::string chunk = "1;" + std::string(1000, 'a') + "\r\nx\r\n";
  Step step = Step::kMore;
  size_t sent = 0;
  std::string unused;
  while (step == Step::kMore && sent < 2 * kMaxBodyWireBytes) {
    unused += chunk;
    sent += chunk.size();
    step = reader.Feed(unused, used);
    unused.erase(0, used);
  }
  EXPECT_EQ(step, Step::kRefused);
  EXPECT_EQ(reader.refusal().status, 413);
}

TEST(RequestReaderTest, WhatABrowserWouldHaveEncodedIsEncoded) {
  RequestReader reader;
  size_t used = 0;
  ASSERT_EQ(reader.Feed("GET /a|\xc3\xa4%zz%41?b=\"[]\" HTTP/1.1\r\nHost: a\r\n\r\n", used),
            Step::kRequest);
  EXPECT_EQ(reader.request().path, "/a%7C%C3%A4%25zz%41");
  EXPECT_EQ(reader.request().query["b"], "\"[]\"");
}

TEST(RequestReaderTest, TheAbsoluteFormOfATargetIsItsPath) {
  const std::pair<const char*, const char*> targets[] = {
      {"http://a/b?c=d", "/b"}, {"https://a", "/"}, {"http://a?c=d", "/"}};
  for (const auto& [target, path] : targets) {
    RequestReader reader;
    size_t used = 0;
    const std::string head = std::string("GET ") + target + " HTTP/1.1\r\nHost: a\r\n\r\n";
    ASSERT_EQ(reader.Feed(head, used), Step::kRequest) << target;
    EXPECT_EQ(reader.request().path, path);
  }
}

}  // namespace
}  // namespace enamel::server::http
