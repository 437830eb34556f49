#include "server/http/wire/response_head.h"

#include <gtest/gtest.h>

namespace enamel::server::http {
namespace {

TEST(ResponseHeadTest, IsWhatTravels) {
  Response response;
  response.content_type = "application/json";
  response.headers = {{"ETag", "\"7\""}};
  EXPECT_EQ(HeadText(response, true, 12),
            "HTTP/1.1 200 OK\r\nETag: \"7\"\r\nContent-Type: application/json\r\n"
            "Content-Length: 12\r\n\r\n");
}

TEST(ResponseHeadTest, SaysThatTheConnectionEnds) {
  Response response;
  response.status = 304;
  EXPECT_EQ(HeadText(response, false, std::nullopt),
            "HTTP/1.1 304 Not Modified\r\nConnection: close\r\n\r\n");
}

// Response splitting (CWE-113): what somebody else wrote never becomes a header or a body.
TEST(ResponseHeadTest, LeavesOutAHeaderThatHoldsALineEnd) {
  Response response;
  response.headers = {{"Location", "/a\r\nSet-Cookie: x=1"},
                      {"X-A\nB", "1"},
                      {"X-Nul", std::string("a\0b", 3)},
                      {"X-Kept", "yes"}};
  EXPECT_EQ(HeadText(response, true, std::nullopt), "HTTP/1.1 200 OK\r\nX-Kept: yes\r\n\r\n");
}

}  // namespace
}  // namespace enamel::server::http
