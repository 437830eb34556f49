#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <map>
#include <sstream>

#include "server/http/wire/request_reader.h"
#include "tests/server/http/desync_suite.h"
#include "tests/server/http/running_server.h"

// Raw bytes over a loopback connection to the whole server. What comes behind a suspicious request
// is a second one, for something that only it asks for: if it is answered, it was smuggled.
namespace enamel::server::http {
namespace {

const std::string kSecond = "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n";
const std::string kPost = "POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\n";
const std::string kChunked = kPost + "Transfer-Encoding: chunked\r\n\r\n";

// What the program's log says while this lives.
class CapturedLog {
 public:
  CapturedLog() : before_(spdlog::default_logger()) {
    auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(text_);
    spdlog::set_default_logger(std::make_shared<spdlog::logger>("captured", sink));
  }
  ~CapturedLog() { spdlog::set_default_logger(before_); }
  size_t Lines(const std::string& with) const {
    size_t count = 0;
    std::istringstream in(text_.str());
    for (std::string line; std::getline(in, line);) count += line.find(with) != line.npos;
    return count;
  }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

struct Outcome {
  int status = 0;      // of the first answer; 0: none
  size_t answers = 0;  // until the server ended the connection
};

class DesyncTest : public testing::Test {
 protected:
  // All of it at once, then nothing more.
  Outcome Send(const std::string& bytes) {
    RawClient client(server_.port());
    client.Send(bytes);
    client.EndSending();
    const std::string text = client.ReadToEnd();
    Outcome out;
    for (size_t at = 0; (at = text.find("HTTP/1.1 ", at)) != text.npos; ++at) ++out.answers;
    if (text.starts_with("HTTP/1.1 ")) out.status = std::stoi(text.substr(9, 3));
    return out;
  }

  School school_;
  CapturedLog log_;  // around the server, whose threads write to it
  RunningServer server_{school_};
};

// The body that the headers announce, as far as they agree on one.
std::string BodyOf(const DesyncCase& request) {
  for (const auto& [name, value] : request.headers) {
    if (name == "Content-Length") return std::string(std::stoul(value), 'x');
    if (name == "Transfer-Encoding") return "0\r\n\r\n";
  }
  return "";
}

TEST_F(DesyncTest, NothingThatTheSuiteCallsAmbiguousOrSevereIsAcceptedNorWhatComesBehindIt) {
  std::vector<DesyncCase> cases = SharedDesyncCases();
  if (cases.empty()) GTEST_SKIP() << "skipped: no shared data";
  size_t dangerous = 0;
  for (const DesyncCase& request : cases) {
    ASSERT_FALSE(request.tier.empty()) << request.name;
    if (request.tier != "Ambiguous" && request.tier != "Severe") continue;
    ++dangerous;
    Outcome outcome = Send(request.Head() + "0\r\n\r\n" + kSecond);
    EXPECT_EQ(outcome.status, 400) << request.name << "\n" << request.Head();
    EXPECT_EQ(outcome.answers, 1u) << request.name;
  }
  EXPECT_GT(dangerous, 0u);
  EXPECT_EQ(log_.Lines("page: refused a peer at 127.0.0.1: 400"), 1u);  // once, not each time
}

// Well-formed requests are served, unless this server does not speak them (request_head.h).
TEST_F(DesyncTest, WhatTheSuiteCallsCompliantIsServedOrAnsweredWithWhyNot) {
  std::vector<DesyncCase> cases = SharedDesyncCases();
  if (cases.empty()) GTEST_SKIP() << "skipped: no shared data";
  std::map<int, size_t> answers;
  for (const DesyncCase& request : cases) {
    if (request.tier != "Compliant") continue;
    bool served = true;
    for (const auto& [name, value] : request.headers) {
      served &= name != "Transfer-Encoding" || value.find_first_of(",;") == value.npos;
      served &= name != "Transfer-Encoding" || value.find("chunked") != value.npos;
    }
    Outcome outcome = Send(request.Head() + BodyOf(request));
    ++answers[outcome.status];
    if (request.uri.empty()) {
      EXPECT_EQ(outcome.status, 400) << request.name;
    } else if (!served) {
      EXPECT_TRUE(outcome.status == 501 || outcome.status == 400) << request.name;
    } else {
      EXPECT_NE(outcome.status, 0) << request.name;
      EXPECT_NE(outcome.status, 400) << request.name;
      EXPECT_LT(outcome.status, 500) << request.name;
    }
  }
  for (auto [status, count] : answers) std::printf("compliant, answered %d: %zu\n", status, count);
}

TEST_F(DesyncTest, WhatTheSuiteCallsAcceptableIsAcceptedOnlyWithALengthOfZero) {
  std::vector<DesyncCase> cases = SharedDesyncCases();
  if (cases.empty()) GTEST_SKIP() << "skipped: no shared data";
  for (const DesyncCase& request : cases) {
    if (request.tier != "Acceptable") continue;
    int status = Send(request.Head() + BodyOf(request)).status;
    if (request.reason == "GetHeadZeroContentLength") {
      EXPECT_TRUE(status == 200 || status == 404) << request.name << " " << status;
    } else {
      EXPECT_TRUE(status == 400 || status == 505) << request.name << " " << status;
    }
  }
}

// Framing that RFC 9112 forbids or leaves to the reader; section in parentheses.
TEST_F(DesyncTest, NoSecondRequestGetsThroughInTheBodyOfTheFirst) {
  const std::pair<const char*, std::string> streams[] = {
      {"folded header (5.2)", kPost + "X: a\r\n Content-Length: 5\r\n\r\n"},
      {"lone LF as line end (2.2)", kPost + "X: a\nContent-Length: 0\r\n\r\n"},
      {"lone LF ends the head", "GET /healthz HTTP/1.1\nHost: localhost\n\n"},
      {"lone CR (2.2)", kPost + "X: a\rContent-Length: 0\r\n\r\n"},
      {"NUL in a value (5.5)", kPost + std::string("X: a\0b\r\n\r\n", 10)},
      {"empty line in front", "\r\n" + kPost + "\r\n"},
      {"space before the colon (5.1)", kPost + "Content-Length : 0\r\n\r\n"},
      {"two lengths (6.3)", kPost + "Content-Length: 0\r\nContent-Length: 44\r\n\r\n"},
      {"the same length twice", kPost + "Content-Length: 0\r\nContent-Length: 0\r\n\r\n"},
      {"list of lengths", kPost + "Content-Length: 0, 0\r\n\r\n"},
      {"negative length", kPost + "Content-Length: -1\r\n\r\n"},
      {"length with sign", kPost + "Content-Length: +0\r\n\r\n"},
      {"hexadecimal length", kPost + "Content-Length: 0x0\r\n\r\n"},
      {"both framings (6.3)",
       kPost + "Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"},
      {"both, other order",
       kPost + "Transfer-Encoding: chunked\r\nContent-Length: 5\r\n\r\n0\r\n\r\n"},
      {"chunked twice", kPost + "Transfer-Encoding: chunked, chunked\r\n\r\n0\r\n\r\n"},
      {"chunked not last (6.3)", kPost + "Transfer-Encoding: chunked, identity\r\n\r\n0\r\n\r\n"},
      {"coding only", kPost + "Transfer-Encoding: gzip\r\n\r\n"},
      {"unknown coding (6.1)", kPost + "Transfer-Encoding: cow\r\n\r\n"},
      {"codings in front", kPost + "Transfer-Encoding: gzip, chunked\r\n\r\n0\r\n\r\n"},
      {"vertical tab", kPost + "Transfer-Encoding:\x0b"
                               "chunked\r\n\r\n0\r\n\r\n"},
      {"quoted coding", kPost + "Transfer-Encoding: \"chunked\"\r\n\r\n0\r\n\r\n"},
      {"underscore", kPost + "Transfer_Encoding: chunked\r\n\r\n0\r\n\r\n"},
      {"coding with HTTP/1.0 (6.1)",
       "POST / HTTP/1.0\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"},
      {"body with GET", "GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: " +
                            std::to_string(kSecond.size()) + "\r\n\r\n"},
      {"two hosts (3.2)", "GET / HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n"},
      {"no host (3.2)", "GET / HTTP/1.1\r\n\r\n"},
      {"other authority (3.2.2)", "GET http://other/ HTTP/1.1\r\nHost: localhost\r\n\r\n"},
      {"authority form", "CONNECT localhost:80 HTTP/1.1\r\nHost: localhost\r\n\r\n"},
      {"no version", "GET /healthz\r\nHost: localhost\r\n\r\n"},
      {"two versions", "GET /healthz HTTP/1.1 HTTP/1.1\r\nHost: localhost\r\n\r\n"},
      {"HTTP/2 preface", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"},
      {"a TLS hello", std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11)},
      {"an answer", "HTTP/1.1 200 OK\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n"},
      {"size without digits (7.1)", kChunked + "\r\n\r\n"},
      {"size with 0x", kChunked + "0x0\r\n\r\n"},
      {"negative size", kChunked + "-0\r\n\r\n"},
      {"size beyond 64 bits", kChunked + "10000000000000000\r\n\r\n"},
      {"size with a space in front", kChunked + " 0\r\n\r\n"},
      {"size, then a word", kChunked + "0 GET\r\n\r\n"},
      {"size ends with LF", kChunked + "0\n\r\n"},
      {"size ends with CR", kChunked + "0\r\r\n\r\n"},
      {"extension with a line end", kChunked + "1;a=\"\n\"\r\nx\r\n0\r\n\r\n"},
      {"extension with NUL", kChunked + std::string("1;a=\0\r\nx\r\n0\r\n\r\n", 15)},
      {"extension without name", kChunked + "1;\r\nx\r\n0\r\n\r\n"},
      {"chunk longer than it says", kChunked + "1\r\nxy\r\n0\r\n\r\n"},
      {"chunk ends with LF", kChunked + "1\r\nx\n0\r\n\r\n"},
      {"chunk without its end", kChunked + "1\r\nx0\r\n\r\n"},
      {"framing in the trailer (6.5.1)", kChunked + "0\r\nContent-Length: 5\r\n\r\n"},
      {"coding in the trailer", kChunked + "0\r\nTransfer-Encoding: chunked\r\n\r\n"},
      {"trailer without colon", kChunked + "0\r\nGET / HTTP/1.1\r\n\r\n"},
  };
  for (const auto& [name, bytes] : streams) {
    Outcome outcome = Send(bytes + kSecond);
    EXPECT_EQ(outcome.answers, 1u) << name;
    EXPECT_GE(outcome.status, 400) << name;
    EXPECT_NE(outcome.status, 500) << name;
  }
  EXPECT_EQ(log_.Lines("page: refused a peer at 127.0.0.1: 400"), 1u);
  EXPECT_LE(log_.Lines("page: refused"), 5u);  // 400, 413, 421, 501, 505
  EXPECT_EQ(Send(kSecond).status, 200);        // others are not affected
}

TEST_F(DesyncTest, WhatIsTooLongIsRefusedWhereverItStands) {
  const std::string much(kMaxHeadBytes, 'a');
  EXPECT_EQ(Send("GET /" + much + " HTTP/1.1\r\nHost: localhost\r\n\r\n").status, 431);
  EXPECT_EQ(Send(much).status, 431);
  EXPECT_EQ(Send("GET / HTTP/1.1\r\nHost: " + much + "\r\n\r\n").status, 431);
  EXPECT_EQ(Send("GET / HTTP/1.1\r\n" + much + ": a\r\n\r\n").status, 431);
  EXPECT_EQ(Send(kChunked + "1;a=" + much + "\r\nx\r\n0\r\n\r\n" + kSecond).answers, 1u);
  EXPECT_EQ(Send(kChunked + "0\r\nX: " + much + much + "\r\n\r\n" + kSecond).answers, 1u);
  std::string many = "GET / HTTP/1.1\r\nHost: localhost\r\n";
  while (many.size() < kMaxHeadBytes) many += "a:b\r\n";
  EXPECT_EQ(Send(many + "\r\n").status, 431);
}

TEST_F(DesyncTest, TrailersAreNoHeaders) {
  RawClient client(server_.port());
  client.Send(kPost +
              "Transfer-Encoding: chunked\r\n\r\n2;a=b;c=\"d\"\r\n{}\r\n0\r\n"
              "Content-Type: application/json\r\nConnection: close\r\n\r\n" +
              kSecond);
  EXPECT_EQ(client.Read()->status, 415);  // Content-Type came too late
  EXPECT_EQ(client.Read()->status, 200);  // Connection too
}

}  // namespace
}  // namespace enamel::server::http
