#include "server/http/site.h"

#include <gtest/gtest.h>

namespace enamel::server::http {
namespace {

const std::vector<std::string> kLoopback = {"127.0.0.1", "localhost", "[::1]"};

TEST(SiteTest, AcceptsOwnHostNamesWithAnyPort) {
  for (const char* host : {"localhost", "LOCALHOST:8080", "127.0.0.1:1", "[::1]", "[::1]:8080"}) {
    EXPECT_TRUE(HostAllowed(host, kLoopback)) << host;
  }
}

TEST(SiteTest, RefusesHostNamesThatOnlyResolveHere) {
  for (const char* host :
       {"", "evil.example", "localhost.evil.example", "127.0.0.1.evil.example",
        "localhost:", "localhost:80a", "[::1", "::1", "localhost:123456", "[::1]x"}) {
    EXPECT_FALSE(HostAllowed(host, kLoopback)) << host;
  }
}

Request From(std::map<std::string, std::string> headers) {
  Request request;
  request.method = Method::kPost;
  request.headers = std::move(headers);
  request.headers["host"] = "localhost:8080";
  return request;
}

TEST(SiteTest, RefusesRequestsMadeByOtherSites) {
  EXPECT_TRUE(CheckSameSite(From({})).ok());
  EXPECT_TRUE(CheckSameSite(From({{"origin", "http://localhost:8080"}})).ok());
  EXPECT_TRUE(CheckSameSite(From({{"sec-fetch-site", "same-origin"}})).ok());
  EXPECT_FALSE(CheckSameSite(From({{"origin", "null"}})).ok());
  EXPECT_FALSE(CheckSameSite(From({{"origin", "http://localhost:8081"}})).ok());
  EXPECT_FALSE(CheckSameSite(From({{"origin", "https://localhost:8080"}})).ok());
  EXPECT_FALSE(CheckSameSite(From({{"sec-fetch-site", "cross-site"}})).ok());
  EXPECT_FALSE(CheckSameSite(From({{"sec-fetch-site", "same-site"}})).ok());
}

TEST(SiteTest, FindsTheSessionCookieOnlyWhenItIsThereOnce) {
  EXPECT_EQ(SessionCookie(From({{"cookie", "a=b; enamel_session=12; c=d"}})), "12");
  EXPECT_EQ(SessionCookie(From({{"cookie", "enamel_session=1; enamel_session=2"}})), std::nullopt);
  EXPECT_EQ(SessionCookie(From({{"cookie", "xenamel_session=1"}})), std::nullopt);
  EXPECT_EQ(SessionCookie(From({})), std::nullopt);
}

TEST(SiteTest, ReadsOnlyTheHostCookieOverTls) {
  Request request = From({{"cookie", "enamel_session=1; __Host-enamel_session=2"}});
  request.tls = true;
  EXPECT_EQ(SessionCookie(request), "2");
  EXPECT_EQ(DeviceCookie(From({{"cookie", "enamel_device=3; enamel_session=1"}})), "3");
  EXPECT_EQ(DeviceCookie(From({{"cookie", "enamel_session=1"}})), "");
  EXPECT_EQ(SetDeviceCookie("3", true),
            "__Host-enamel_device=3; Path=/; HttpOnly; SameSite=Strict; Secure; Max-Age=2592000");
  EXPECT_EQ(SetSessionCookie("2", true),
            "__Host-enamel_session=2; Path=/; HttpOnly; SameSite=Strict; Secure");
}

}  // namespace
}  // namespace enamel::server::http
