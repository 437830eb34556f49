#include "server/live/remark_board.h"

#include <gtest/gtest.h>

namespace enamel::server {
namespace {

constexpr UnixMs kNow = 1'700'000'000'000;

class RemarkBoardTest : public ::testing::Test {
 protected:
  uint64_t Send(const std::string& text, UnixMs now_ms = kNow) {
    board_.Put(Remark(attempt_, ++last_id_, text, now_ms));
    return last_id_;
  }
  static ChairRemark Remark(const Uuid& attempt, uint64_t id, const std::string& text,
                            UnixMs now_ms) {
    return {attempt, id, text, "Ada", 5, now_ms, RemarkState::kWaiting, 0};
  }
  RemarkState StateOf(size_t index) { return board_.Of(attempt_).at(index).state; }

  RemarkBoard board_;
  const Uuid attempt_ = Uuid::New();
  uint64_t last_id_ = 0;
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

TEST_F(RemarkBoardTest, AChairIsNotFlooded) {
  for (size_t i = 0; i < RemarkBoard::kMaxWaiting; ++i) {
    ASSERT_TRUE(board_.Admit(attempt_, kNow).ok());
    (void)Send("r");
  }
  EXPECT_EQ(board_.Admit(attempt_, kNow).code(), Code::kConflict);
  EXPECT_TRUE(board_.Admit(Uuid::New(), kNow).ok()) << "another attempt's chair";
  (void)board_.Take(attempt_);
  board_.Shown(attempt_, ~uint64_t{0}, kNow);
  for (size_t i = RemarkBoard::kMaxWaiting; i < RemarkBoard::kMaxAMinute; ++i) {
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
  for (size_t i = 0; i < 3 * RemarkBoard::kMaxKept; ++i) (void)Send(std::to_string(i));
  EXPECT_EQ(board_.Of(attempt_).size(), RemarkBoard::kMaxKept);
  EXPECT_EQ(board_.Take(attempt_).size(), RemarkBoard::kMaxWaiting);
  for (size_t i = 0; i < RemarkBoard::kMaxAttempts; ++i) {
    board_.Put(Remark(Uuid::New(), 1000 + i, "r", kNow));
  }
  EXPECT_TRUE(board_.Of(attempt_).empty()) << "the one silent longest goes first";
  const Uuid other = Uuid::New();
  board_.Put(Remark(other, ~uint64_t{0}, "r", kNow));
  board_.Remove(other);
  EXPECT_TRUE(board_.Of(other).empty());
  EXPECT_TRUE(board_.Take(other).empty());
}

TEST_F(RemarkBoardTest, WhatTheStoreHasIsPutInItsPlaceAndNeverTakesARemarkBack) {
  (void)Send("one");
  (void)Send("three");
  board_.Put(Remark(attempt_, 5, "five", kNow));
  board_.Put(Remark(attempt_, 3, "said at another server, read later", kNow));
  std::vector<uint64_t> ids;
  for (const ChairRemark& remark : board_.Of(attempt_)) ids.push_back(remark.id);
  EXPECT_EQ(ids, (std::vector<uint64_t>{1, 2, 3, 5}));
  (void)board_.Take(attempt_);
  board_.Shown(attempt_, 2, kNow + 9);
  ChairRemark read = Remark(attempt_, 1, "one", kNow);
  board_.Put(read);
  EXPECT_EQ(StateOf(0), RemarkState::kShown) << "the store is behind";
  read = Remark(attempt_, 5, "five", kNow);
  read.state = RemarkState::kShown;
  read.shown_ms = kNow + 3;
  board_.Put(read);
  EXPECT_EQ(StateOf(3), RemarkState::kShown) << "shown by another server's station";
  EXPECT_EQ(board_.Of(attempt_)[3].shown_ms, kNow + 3);
}

TEST_F(RemarkBoardTest, WhatHasMovedIsToldUntilItIsStored) {
  (void)Send("one");
  (void)Send("two");
  EXPECT_TRUE(board_.Moved().empty());
  (void)board_.Take(attempt_);
  const std::vector<ChairRemark> sent = board_.Moved();
  ASSERT_EQ(sent.size(), 2u);
  board_.Shown(attempt_, 1, kNow);
  board_.Stored(sent);
  const std::vector<ChairRemark> shown = board_.Moved();
  ASSERT_EQ(shown.size(), 1u) << "moved on while it was stored";
  EXPECT_EQ(shown[0].id, 1u);
  EXPECT_EQ(shown[0].state, RemarkState::kShown);
  board_.Stored(shown);
  EXPECT_TRUE(board_.Moved().empty());
  board_.Remove(attempt_);
  board_.Stored(shown);
  EXPECT_TRUE(board_.Of(attempt_).empty());
}

TEST_F(RemarkBoardTest, AttemptsThatAreOverGo) {
  (void)Send("one");
  const Uuid over = Uuid::New(), new_one = Uuid::New();
  board_.Put(Remark(over, 1, "r", kNow));
  board_.Put(Remark(new_one, 1, "r", kNow + 2000));
  board_.KeepOnly({attempt_}, kNow + 1000);
  EXPECT_EQ(board_.Of(attempt_).size(), 1u);
  EXPECT_TRUE(board_.Of(over).empty());
  EXPECT_EQ(board_.Of(new_one).size(), 1u);
}

}  // namespace
}  // namespace enamel::server
