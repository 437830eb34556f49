#include "server/http/kept.h"

#include <gtest/gtest.h>

#include <map>

#include "common/timeline/deflate.h"

namespace enamel::server::http {
namespace {

const std::string kAll = "0123456789";

struct Answer {
  int status;
  std::string body;
  std::map<std::string, std::string> headers;
};

Answer Ask(std::map<std::string, std::string> headers, int* reads = nullptr,
           const std::string& all = kAll) {
  Request request;
  request.headers = std::move(headers);
  const Kept kept{HashSha256(AsBytes("name")), "application/octet-stream",
                  "private, max-age=31536000, immutable"};
  SharedBodies bodies;
  Response response = KeptResponse(request, kept, bodies, [&]() -> Result<Bytes> {
    if (reads) ++*reads;
    return Bytes(all.begin(), all.end());
  });
  return {response.status,
          std::string(response.Body()),
          {response.headers.begin(), response.headers.end()}};
}

TEST(KeptTest, JsonIsPackedForWhoTakesItAndWhereThatIsWorthIt) {
  const auto pack = [](std::string type, size_t size, const char* accepted) {
    Request request;
    request.headers["accept-encoding"] = accepted;
    Response response;
    response.content_type = std::move(type);
    response.body = std::string(size, 'x');
    Response packed = Packed(request, std::move(response));
    const std::map<std::string, std::string> headers(packed.headers.begin(), packed.headers.end());
    return std::pair(headers.contains("Content-Encoding"), std::string(packed.Body()));
  };
  const auto [is_packed, body] = pack("application/json", 5000, "gzip, deflate");
  EXPECT_TRUE(is_packed);
  EXPECT_LT(body.size(), 100u);
  auto back = timeline::Inflate(AsBytes(body), 5000, "answer", "body");
  ASSERT_TRUE(back.ok()) << back.status().message();
  EXPECT_EQ(AsText(*back), std::string(5000, 'x'));
  EXPECT_FALSE(pack("application/json", 5000, "gzip, br").first);
  EXPECT_FALSE(pack("application/json", 100, "deflate").first);
  EXPECT_FALSE(pack("application/octet-stream", 5000, "deflate").first);
}

TEST(KeptTest, WithoutARangeItIsAllThere) {
  Answer answer = Ask({});
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body, kAll);
  EXPECT_EQ(answer.headers["Accept-Ranges"], "bytes");
  EXPECT_EQ(answer.headers["Cache-Control"], "private, max-age=31536000, immutable");
  EXPECT_EQ(answer.headers["ETag"], '"' + HashSha256(AsBytes("name")).Hex().substr(0, 32) + '"');
}

TEST(KeptTest, OneRangeIsGivenAsRfc9110CountsIt) {
  struct Case {
    const char *range, *body, *content_range;
  };
  for (const Case& c :
       {Case{"bytes=0-0", "0", "bytes 0-0/10"}, Case{"bytes=2-4", "234", "bytes 2-4/10"},
        Case{"bytes=7-", "789", "bytes 7-9/10"}, Case{"bytes=8-99", "89", "bytes 8-9/10"},
        Case{"bytes=-3", "789", "bytes 7-9/10"}, Case{"bytes=-99", "0123456789", "bytes 0-9/10"}}) {
    Answer answer = Ask({{"range", c.range}});
    EXPECT_EQ(answer.status, 206) << c.range;
    EXPECT_EQ(answer.body, c.body) << c.range;
    EXPECT_EQ(answer.headers["Content-Range"], c.content_range) << c.range;
  }
}

TEST(KeptTest, ARangeBeyondTheEndIsRefusedWithTheSize) {
  for (const char* range : {"bytes=10-", "bytes=10-12", "bytes=-0"}) {
    Answer answer = Ask({{"range", range}});
    EXPECT_EQ(answer.status, 416) << range;
    EXPECT_EQ(answer.headers["Content-Range"], "bytes */10") << range;
  }
  EXPECT_EQ(Ask({{"range", "bytes=0-0"}}, nullptr, "").status, 416) << "there is no first byte";
}

TEST(KeptTest, WhatIsNoSingleRangeGivesAllOfIt) {
  for (const char* range : {"bytes=0-1,4-5", "bytes=4-2", "bytes=a-b", "bytes=", "bytes=-",
                            "lines=0-1", "bytes=1-2x", "bytes=99999999999999999999-"}) {
    Answer answer = Ask({{"range", range}});
    EXPECT_EQ(answer.status, 200) << range;
    EXPECT_EQ(answer.body, kAll) << range;
  }
}

TEST(KeptTest, WhoHasItGetsNothingAndItIsNotRead) {
  const std::string tag = Ask({}).headers["ETag"];
  int reads = 0;
  Answer answer = Ask({{"if-none-match", "\"other\", " + tag}}, &reads);
  EXPECT_EQ(answer.status, 304);
  EXPECT_EQ(answer.body, "");
  EXPECT_EQ(reads, 0);
  EXPECT_EQ(Ask({{"if-none-match", "\"other\""}}, &reads).status, 200);
  EXPECT_EQ(reads, 1);
}

TEST(KeptTest, ARangeOfSomethingElseGivesAllOfThis) {
  const std::string tag = Ask({}).headers["ETag"];
  EXPECT_EQ(Ask({{"range", "bytes=0-1"}, {"if-range", tag}}).status, 206);
  EXPECT_EQ(Ask({{"range", "bytes=0-1"}, {"if-range", "\"other\""}}).status, 200);
}

TEST(KeptTest, WhatCannotBeReadIsDamageOfOurs) {
  SharedBodies bodies;
  Response response =
      KeptResponse({}, {HashSha256({}), "text/plain", ""}, bodies,
                   []() -> Result<Bytes> { return Status(Code::kNotFound, "no such blob"); });
  EXPECT_EQ(response.status, 500);
}

}  // namespace
}  // namespace enamel::server::http
