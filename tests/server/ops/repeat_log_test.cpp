#include "server/ops/repeat_log.h"

#include <gtest/gtest.h>

#include <vector>

namespace enamel::server::ops {
namespace {

using namespace std::chrono_literals;

struct Log {
  std::vector<std::string> lines;
  std::chrono::steady_clock::time_point now{};
  RepeatLog log{[this](const std::string& line) { lines.push_back(line); }, [this] { return now; }};

  void Note(const std::string& peer, const char* code, const char* message = "reason") {
    log.Note(peer + "\n" + code, peer + ": " + code + ": " + message);
  }
};

TEST(RepeatLogTest, SameRefusalIsSaidOnceAMinuteAndThenWithItsNumber) {
  Log log;
  for (int i = 0; i < 100; ++i) log.Note("10.0.0.1", "forbidden");
  ASSERT_EQ(log.lines.size(), 1u);
  EXPECT_NE(log.lines[0].find("10.0.0.1"), std::string::npos);
  EXPECT_NE(log.lines[0].find("forbidden: reason"), std::string::npos);
  log.now += RepeatLog::kQuiet;
  log.Note("10.0.0.1", "forbidden");
  ASSERT_EQ(log.lines.size(), 2u);
  EXPECT_NE(log.lines[1].find("99 more"), std::string::npos) << log.lines[1];
}

TEST(RepeatLogTest, OtherPeersAndOtherReasonsAreSaidByThemselves) {
  Log log;
  log.Note("10.0.0.1", "forbidden");
  log.Note("10.0.0.2", "forbidden");
  log.Note("10.0.0.1", "conflict");
  EXPECT_EQ(log.lines.size(), 3u);
}

TEST(RepeatLogTest, WhatAPeerWroteCannotMakeALineOfItsOwn) {
  Log log;
  log.Note("10.0.0.1", "forbidden", "a\nstation link: all is well\x1b[2J");
  ASSERT_EQ(log.lines.size(), 1u);
  for (char c : log.lines[0]) EXPECT_GE(static_cast<unsigned char>(c), 0x20);
}

TEST(RepeatLogTest, ManyPeersAreForgottenOldestFirst) {
  Log log;
  log.Note("first", "forbidden");
  for (size_t i = 0; i < RepeatLog::kMaxKeys; ++i) {
    log.now += 1ms;
    log.Note(std::to_string(i), "forbidden");
  }
  size_t before = log.lines.size();
  log.Note("first", "forbidden");
  EXPECT_EQ(log.lines.size(), before + 1);
}

}  // namespace
}  // namespace enamel::server::ops
