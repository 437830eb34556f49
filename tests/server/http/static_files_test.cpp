#include "server/http/static_files.h"

#include <gtest/gtest.h>

#include "tests/support/temp_folder.h"

namespace enamel::server::http {
namespace {

class StaticFilesTest : public testing::Test {
 protected:
  StaticFilesTest() {
    secret_.Write("secret.txt", "secret");
    folder_.Write("index.html", "<!doctype html>page");
    folder_.Write("attempts/index.html", "<!doctype html>one attempt");
    folder_.Write("assets/main-4XKQ7B2D.js", "plain script");
    folder_.Write("assets/main-4XKQ7B2D.js.br", "brotli");
    folder_.Write("assets/main-4XKQ7B2D.js.gz", "gzip");
    folder_.Write("favicon.svg", "<svg/>");
    folder_.Write("orphan.js.gz", "no plain form");
    std::filesystem::create_symlink(secret_.path() / "secret.txt", folder_.path() / "link.txt");
    Result<StaticFiles> loaded = StaticFiles::Load(folder_.path());
    EXPECT_TRUE(loaded.ok()) << loaded.status().message();
    files_ = std::move(*loaded);
  }

  Response Get(const std::string& path, std::map<std::string, std::string> headers = {}) const {
    Request request;
    request.path = path;
    request.headers = std::move(headers);
    return files_->Serve(request);
  }
  static std::string HeaderOf(const Response& response, const std::string& name) {
    for (const auto& [key, value] : response.headers) {
      if (key == name) return value;
    }
    return "";
  }

  test::TempFolder folder_, secret_;
  std::optional<StaticFiles> files_;
};

TEST_F(StaticFilesTest, HashedNamesAreCachedForEverAndIndexNever) {
  Response script = Get("/assets/main-4XKQ7B2D.js");
  EXPECT_EQ(script.Body(), "plain script");
  EXPECT_EQ(script.content_type, "text/javascript; charset=utf-8");
  EXPECT_EQ(HeaderOf(script, "Cache-Control"), "public, max-age=31536000, immutable");
  Response index = Get("/index.html");
  EXPECT_EQ(HeaderOf(index, "Cache-Control"), "no-store");
  EXPECT_EQ(HeaderOf(Get("/attempts/x"), "Cache-Control"), "no-store");
  EXPECT_EQ(HeaderOf(Get("/favicon.svg"), "Cache-Control"), "no-cache");
}

TEST_F(StaticFilesTest, PageAddressesAreTheIndexOfTheNearestFolder) {
  for (const char* path : {"/", "/attempts", "/exercises/0190a5b0-0000-7000-8000-000000000000"}) {
    EXPECT_EQ(Get(path).Body(), "<!doctype html>page") << path;
  }
  for (const char* path : {"/attempts/0190a5b0-0000-7000-8000-000000000000", "/attempts/x/y"}) {
    EXPECT_EQ(Get(path).Body(), "<!doctype html>one attempt") << path;
  }
}

TEST_F(StaticFilesTest, NoPathLeadsOutsideTheFolder) {
  const std::string outside = secret_.path().filename().string();
  for (const std::string& path : std::vector<std::string>{
           "/../" + outside + "/secret.txt", "/..%2f" + outside + "/secret.txt",
           "/%2e%2e/" + outside + "/secret.txt", "/assets/../../" + outside + "/secret.txt",
           "//etc/passwd.txt", "/link.txt", "/.git/config", "/index.html/",
           "/assets\\main-4XKQ7B2D.js"}) {
    EXPECT_EQ(Get(path).status, 404) << path;
  }
}

TEST_F(StaticFilesTest, ServesTheCompressedFormTheBrowserAccepts) {
  auto body = [&](const char* accepted) {
    return std::string(Get("/assets/main-4XKQ7B2D.js", {{"accept-encoding", accepted}}).Body());
  };
  EXPECT_EQ(body("gzip, deflate, br"), "brotli");
  EXPECT_EQ(body("gzip;q=1.0, br;q=0"), "gzip");
  EXPECT_EQ(body("identity"), "plain script");
  Response script = Get("/assets/main-4XKQ7B2D.js", {{"accept-encoding", "br"}});
  EXPECT_EQ(HeaderOf(script, "Content-Encoding"), "br");
  EXPECT_EQ(HeaderOf(script, "Vary"), "Accept-Encoding");
  EXPECT_EQ(Get("/orphan.js").status, 404);
}

TEST_F(StaticFilesTest, AnswersThatTheBrowsersCopyIsStillGood) {
  std::string tag = HeaderOf(Get("/favicon.svg"), "ETag");
  ASSERT_FALSE(tag.empty());
  Response again = Get("/favicon.svg", {{"if-none-match", tag}});
  EXPECT_EQ(again.status, 304);
  EXPECT_TRUE(again.Body().empty());
}

TEST_F(StaticFilesTest, RefusesToChangeAnything) {
  Request request;
  request.method = Method::kPost;
  request.path = "/index.html";
  EXPECT_EQ(files_->Serve(request).status, 405);
}

TEST(StaticFilesLoadTest, SaysWhatIsMissing) {
  test::TempFolder empty;
  Result<StaticFiles> loaded = StaticFiles::Load(empty.path());
  ASSERT_FALSE(loaded.ok());
  EXPECT_EQ(loaded.status().code(), Code::kNotFound);
  EXPECT_NE(loaded.status().message().find("index.html"), std::string::npos);
  EXPECT_EQ(StaticFiles::Load(empty.path() / "none").status().code(), Code::kNotFound);
}

}  // namespace
}  // namespace enamel::server::http
