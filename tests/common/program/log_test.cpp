#include "common/program/log.h"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <boost/json.hpp>
#include <cstdlib>
#include <regex>
#include <sstream>
#include <thread>
#include <vector>

#include "common/base/log_request.h"

namespace enamel::program {
namespace {

class LogTest : public ::testing::Test {
 protected:
  ~LogTest() override { EXPECT_TRUE(SetUpLog({}).ok()); }
};

TEST_F(LogTest, EveryMessageIsOneJsonObjectOnOneLine) {
  ::testing::internal::CaptureStderr();
  ASSERT_TRUE(SetUpLog({"json", "info"}).ok());
  const std::string nasty = "a \"quoted\" name\nlevel: error \x1b[31m \\ ü";
  spdlog::info("sign-in of {}", nasty);
  spdlog::debug("not this one");
  spdlog::error("second");
  std::string said = ::testing::internal::GetCapturedStderr();
  std::istringstream lines(said);
  std::vector<boost::json::object> objects;
  for (std::string line; std::getline(lines, line);) {
    objects.push_back(boost::json::parse(line).as_object());
  }
  ASSERT_EQ(objects.size(), 2u) << said;
  EXPECT_EQ(std::string(objects[0].at("message").as_string()), "sign-in of " + nasty);
  EXPECT_EQ(objects[0].at("level").as_string(), "info");
  EXPECT_EQ(objects[1].at("level").as_string(), "error");
  EXPECT_TRUE(std::regex_match(std::string(objects[0].at("time").as_string()),
                               std::regex(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z)")));
}

TEST_F(LogTest, ALineNamesTheRequestThatItsThreadIsDoing) {
  for (const char* format : {"json", "text"}) {
    ::testing::internal::CaptureStderr();
    ASSERT_TRUE(SetUpLog({format, "info"}).ok());
    spdlog::info("before");
    {
      const LogRequest outer("one");
      {
        const LogRequest inner("two");
        spdlog::info("within");
        std::jthread([] { spdlog::info("beside"); }).join();
      }
      spdlog::info("again");
    }
    spdlog::info("after");
    const std::string said = ::testing::internal::GetCapturedStderr();
    std::string ids;
    const std::regex named(R"((?:"request":"|\[request )(\w+))");
    for (std::sregex_iterator at(said.begin(), said.end(), named), end; at != end; ++at) {
      ids += (*at)[1].str() + " ";
    }
    EXPECT_EQ(ids, "two one ") << said;
  }
  EXPECT_TRUE(LogRequest::IsId(LogRequest::NewId()));
  EXPECT_NE(LogRequest::NewId(), LogRequest::NewId());
  EXPECT_TRUE(LogRequest::IsId("6F-a_b.c"));
  for (const char* bad : {"", "a b", "a\nb", "ä"}) EXPECT_FALSE(LogRequest::IsId(bad)) << bad;
  EXPECT_TRUE(LogRequest::IsId(std::string(64, 'a')));
  EXPECT_FALSE(LogRequest::IsId(std::string(65, 'a')));
}

TEST_F(LogTest, ALineNamesTheAttemptThatItsThreadIsAbout) {
  const Uuid id = *Uuid::Parse("0190a5b2-0000-7000-8000-00000000000a");
  for (const auto& [format, named] : {std::pair("json", "\"attempt\":\"" + id.Text() + "\""),
                                      std::pair("text", "[attempt " + id.Text() + "] ")}) {
    ::testing::internal::CaptureStderr();
    ASSERT_TRUE(SetUpLog({format, "info"}).ok());
    {
      const LogAttempt attempt(id);
      spdlog::info("about it");
      const LogAttempt none(Uuid{});
      spdlog::info("about none");
    }
    spdlog::info("after");
    const std::string said = ::testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find(named), std::string::npos) << said;
    EXPECT_LT(said.find(named), said.find("about none")) << said;
    EXPECT_EQ(said.find("attempt", said.find("about none")), std::string::npos) << said;
  }
}

TEST_F(LogTest, WhatAProgramSaysLastIsALineOfItsLogWhateverItsLevel) {
  ::testing::internal::CaptureStderr();
  ASSERT_TRUE(SetUpLog({"json", "error", "prog"}).ok());
  SayError("it \"broke\"");
  SayWarning("nothing is lost");
  spdlog::warn("not this one");
  ASSERT_TRUE(SetUpLog({"text", "error", "prog"}).ok());
  SayError("plain");
  std::istringstream lines(::testing::internal::GetCapturedStderr());
  std::string first, second, third, more;
  std::getline(lines, first);
  std::getline(lines, second);
  std::getline(lines, third);
  EXPECT_FALSE(std::getline(lines, more)) << more;
  EXPECT_EQ(boost::json::parse(first).at("message").as_string(), "it \"broke\"");
  EXPECT_EQ(boost::json::parse(first).at("level").as_string(), "error");
  EXPECT_EQ(boost::json::parse(second).at("level").as_string(), "warning");
  EXPECT_EQ(third, "prog: plain");
}

TEST_F(LogTest, WhatIsNotUtf8IsReplacedInALineOfJson) {
  ::testing::internal::CaptureStderr();
  ASSERT_TRUE(SetUpLog({"json", "info", "prog"}).ok());
  EXPECT_TRUE(LogIsJson());
  SayError("no option --\xff or \xc3(");
  const std::string said = ::testing::internal::GetCapturedStderr();
  boost::system::error_code error;
  const auto line = boost::json::parse(said, error);
  ASSERT_FALSE(error) << said;
  EXPECT_EQ(line.at("message").as_string(), "no option --\xef\xbf\xbd or \xef\xbf\xbd(");
  ASSERT_TRUE(SetUpLog({"text", "info", "prog"}).ok());
  EXPECT_FALSE(LogIsJson());
}

TEST_F(LogTest, JsonIsAskedForByTheCommandLineOrElseTheEnvironment) {
  auto asks = [](std::vector<const char*> words) {
    words.insert(words.begin(), "prog");
    return AsksForJson(static_cast<int>(words.size()), words.data(), "ENAMEL_TEST_");
  };
  EXPECT_FALSE(asks({}));
  EXPECT_TRUE(asks({"run", "--log-format", "json"}));
  EXPECT_TRUE(asks({"--log-format=json", "run"}));
  EXPECT_FALSE(asks({"run", "--log-format"}));
  ::setenv("ENAMEL_TEST_LOG_FORMAT", "json", 1);
  EXPECT_TRUE(asks({"run"}));
  EXPECT_FALSE(asks({"run", "--log-format", "text"}));
  ::unsetenv("ENAMEL_TEST_LOG_FORMAT");
}

TEST_F(LogTest, UnknownFormatAndLevelAreRefusedByName) {
  EXPECT_EQ(SetUpLog({"xml", "info"}).field(), "log-format");
  EXPECT_EQ(SetUpLog({"text", "loud"}).field(), "log-level");
}

}  // namespace
}  // namespace enamel::program
