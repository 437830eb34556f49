#include "server/live/remark_board.h"

#include <gtest/gtest.h>

namespace enamel::server {
namespace {

constexpr UnixMs kNow = 1'700'000'000'000;

class RemarkBoardTest : public testing::Test {
 protected:
  uint64_t Send(const std::string& text, UnixMs now_ms = kNow) {
    return board_.Send(attempt_, text, "Ada", 5, now_ms).remark.id;
  }
  RemarkState StateOf(size_t index) { return board_.Of(attempt_).at(index).state; }

  RemarkBoard board_;
  const Uuid attempt_ = Uuid::New();
};

TEST_F(RemarkBoardTest, RemarkIsHandedOutUntilItIsKnownToBeShown) {
  const uint64_t first = Send("one");
  EXPECT_EQ(StateOf(0), RemarkState::kWaiting);
  for (int again = 0; again < 3; ++again) {
    auto taken = board_.Take(attempt_);
    ASSERT_EQ(taken.size(), 1u);
    EXPECT_EQ(taken[0].id, first);
    EXPECT_EQ(taken[0].text, "one");
    EXPECT_EQ(StateOf(0), RemarkState::kSent);
  }
  const uint64_t second = Send("two");
  EXPECT_GT(second, first) << "sent in the same millisecond";
  board_.Shown(attempt_, first, kNow + 7);
  EXPECT_EQ(StateOf(0), RemarkState::kShown);
  EXPECT_EQ(board_.Of(attempt_)[0].shown_ms, kNow + 7);
  auto rest = board_.Take(attempt_);
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_EQ(rest[0].id, second);
}

TEST_F(RemarkBoardTest, WhatWasNeverSentIsNotShownWhateverTheStationSays) {
  (void)Send("one");
  board_.Shown(attempt_, ~uint64_t{0}, kNow);
  EXPECT_EQ(StateOf(0), RemarkState::kWaiting);
  EXPECT_EQ(board_.Take(attempt_).size(), 1u);
}

TEST_F(RemarkBoardTest, IdsGoOnGrowingWhenTheServerIsStartedAnew) {
  const uint64_t before = Send("before");
  RemarkBoard restarted;
  EXPECT_GT(restarted.Send(attempt_, "after", "Ada", 5, kNow + 2000).remark.id, before);
}

TEST_F(RemarkBoardTest, AChairIsNotFlooded) {
  for (size_t i = 0; i < RemarkBoard::kMostWaiting; ++i) {
    ASSERT_TRUE(board_.Admit(attempt_, kNow).ok());
    (void)Send("r");
  }
  EXPECT_EQ(board_.Admit(attempt_, kNow).code(), Code::kConflict);
  EXPECT_TRUE(board_.Admit(Uuid::New(), kNow).ok()) << "another attempt's chair";
  (void)board_.Take(attempt_);
  board_.Shown(attempt_, ~uint64_t{0}, kNow);
  for (size_t i = RemarkBoard::kMostWaiting; i < RemarkBoard::kMostAMinute; ++i) {
    ASSERT_TRUE(board_.Admit(attempt_, kNow).ok());
    (void)Send("r");
  }
  (void)board_.Take(attempt_);
  board_.Shown(attempt_, ~uint64_t{0}, kNow);
  const Status fast = board_.Admit(attempt_, kNow + 59'999);
  EXPECT_EQ(fast.field(), "throttled");
  EXPECT_TRUE(board_.Admit(attempt_, kNow + 60'000).ok());
}

TEST_F(RemarkBoardTest, WhatItHoldsIsBoundedAndGoesWithTheAttempt) {
  for (size_t i = 0; i < 3 * RemarkBoard::kMostKept; ++i) (void)Send(std::to_string(i));
  EXPECT_EQ(board_.Of(attempt_).size(), RemarkBoard::kMostKept);
  EXPECT_EQ(board_.Take(attempt_).size(), RemarkBoard::kMostWaiting);
  for (size_t i = 0; i < RemarkBoard::kMostAttempts; ++i) {
    (void)board_.Send(Uuid::New(), "r", "Ada", 0, kNow + 1000 + static_cast<UnixMs>(i));
  }
  EXPECT_TRUE(board_.Of(attempt_).empty()) << "the one silent longest goes first";
  const Uuid other = Uuid::New();
  (void)board_.Send(other, "r", "Ada", 0, kNow);
  board_.Remove(other);
  EXPECT_TRUE(board_.Of(other).empty());
  EXPECT_TRUE(board_.Take(other).empty());
}

}  // namespace
}  // namespace enamel::server
