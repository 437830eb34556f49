#include "server/live/live_board.h"

#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>
#include <thread>

namespace enamel::server {
namespace {

LiveSample Sample(const Uuid& attempt, uint64_t tick, UnixMs received_ms = 0) {
  LiveSample sample;
  sample.attempt = attempt;
  sample.tick = tick;
  sample.anchor_um = {1, -2, 3};
  sample.force_mn = {-4, 5, -6};
  sample.flags = 7;
  sample.received_ms = received_ms;
  return sample;
}

TEST(LiveBoardTest, WatcherGetsEachMomentOnce) {
  LiveBoard board;
  Uuid attempt = Uuid::New();
  auto watch = board.Watch(attempt, Uuid{});
  EXPECT_EQ(watch->Next(), nullptr);
  board.Put(Sample(attempt, 1));
  board.Put(Sample(attempt, 2));
  EXPECT_EQ(*watch->Next(), "{\"tick\":2,\"rows\":[[1,1,-2,3,-4,5,-6,7],[2,1,-2,3,-4,5,-6,7]]}");
  EXPECT_EQ(watch->Next(), nullptr);
  board.Put(Sample(attempt, 3));
  EXPECT_EQ(*watch->Next(), "{\"tick\":3,\"rows\":[[3,1,-2,3,-4,5,-6,7]]}");
}

// A viewer that fetches ten times a second sees all of a stream of sixty; one that stays away for
// long misses the older ones.
TEST(LiveBoardTest, SlowWatcherMissesTheOldestOnly) {
  LiveBoard board;
  Uuid attempt = Uuid::New();
  auto quick = board.Watch(attempt, Uuid{}), slow = board.Watch(attempt, Uuid{});
  size_t seen = 0;
  for (uint64_t tick = 0; tick < 300; ++tick) {
    board.Put(Sample(attempt, tick * 16));
    if (tick % 6 != 5) continue;
    seen += boost::json::parse(*quick->Next()).at("rows").as_array().size();
  }
  EXPECT_EQ(seen, 300u);
  boost::json::value event = boost::json::parse(*slow->Next());
  const auto& rows = event.at("rows").as_array();
  ASSERT_EQ(rows.size(), LiveBoard::kMaxRows);
  EXPECT_EQ(rows.front().at(0).as_int64(), (300 - 60) * 16);
  EXPECT_EQ(rows.back().at(0).as_int64(), 299 * 16);
}

TEST(LiveBoardTest, EventIsTheDocumentedJson) {
  LiveBoard board;
  Uuid attempt = Uuid::New();
  auto watch = board.Watch(attempt, Uuid{});
  std::vector<LiveSample> samples = {Sample(attempt, 10), Sample(attempt, 26)};
  board.Put(samples);
  boost::json::value event = boost::json::parse(*watch->Next());
  EXPECT_EQ(event.at("tick").as_int64(), 26);
  ASSERT_EQ(event.at("rows").as_array().size(), 2u);
  for (const auto& row : event.at("rows").as_array()) EXPECT_EQ(row.as_array().size(), 8u);
}

TEST(LiveBoardTest, AllWatchersShareOneEventsBytes) {
  LiveBoard board;
  Uuid attempt = Uuid::New();
  auto one = board.Watch(attempt, Uuid{}), other = board.Watch(attempt, Uuid{});
  board.Put(Sample(attempt, 1));
  EXPECT_EQ(one->Next().get(), other->Next().get());
}

TEST(LiveBoardTest, EarlierOrRepeatedTicksChangeNothing) {
  LiveBoard board;
  Uuid attempt = Uuid::New();
  auto watch = board.Watch(attempt, Uuid{});
  board.Put(Sample(attempt, 9));
  watch->Next();
  board.Put(Sample(attempt, 9));
  board.Put(Sample(attempt, 3));
  EXPECT_EQ(watch->Next(), nullptr);
  EXPECT_EQ(board.Latest(attempt)->tick, 9u);
}

TEST(LiveBoardTest, AttemptIsWatchedAsLongAsSomebodyWatchesIt) {
  LiveBoard board;
  Uuid attempt = Uuid::New();
  EXPECT_FALSE(board.Watched(attempt));
  auto one = board.Watch(attempt, Uuid{}), other = board.Watch(attempt, Uuid{});
  one.reset();
  EXPECT_TRUE(board.Watched(attempt));
  EXPECT_FALSE(board.Watched(Uuid::New()));
  other.reset();
  EXPECT_FALSE(board.Watched(attempt));
}

TEST(LiveBoardTest, SealedAttemptEndsItsWatches) {
  LiveBoard board;
  Uuid attempt = Uuid::New();
  auto watch = board.Watch(attempt, Uuid{});
  board.Put(Sample(attempt, 1));
  board.Remove(attempt);
  watch->Next();
  EXPECT_TRUE(watch->ended());
  EXPECT_FALSE(board.Latest(attempt).has_value());
}

TEST(LiveBoardTest, NumbersAreBounded) {
  ops::Budgets limits;
  limits.views = 9;
  limits.person_views = 4;
  LiveBoard board(limits);
  std::vector<std::unique_ptr<LiveWatch>> watches;
  for (int i = 0; i < limits.views; ++i) watches.push_back(board.Watch(Uuid::New(), Uuid::New()));
  EXPECT_EQ(board.Watch(Uuid::New(), Uuid::New()), nullptr);
  EXPECT_EQ(board.WhyNot(Uuid::New()).field(), "views");
  watches.clear();
  const Uuid one = Uuid::New(), other = Uuid::New();
  for (int i = 0; i < limits.person_views; ++i) watches.push_back(board.Watch(Uuid::New(), one));
  EXPECT_EQ(board.Watch(Uuid::New(), one), nullptr);
  EXPECT_EQ(board.WhyNot(one).field(), "person_views");
  EXPECT_NE(board.Watch(Uuid::New(), other), nullptr) << "nobody takes them from others";
  const auto uses = board.Uses();
  EXPECT_EQ(uses[0].most, 4u);
  EXPECT_EQ(uses[0].of, one.Text());
  EXPECT_EQ(uses[0].refused, 1u);
  EXPECT_EQ(uses[1].limit, 9u);
  EXPECT_EQ(uses[1].refused, 1u);
  watches.pop_back();
  EXPECT_NE(board.Watch(Uuid::New(), one), nullptr);
  Uuid oldest = Uuid::New();
  board.Put(Sample(oldest, 1, 1));
  for (UnixMs i = 0; i < 1024; ++i) board.Put(Sample(Uuid::New(), 1, 2 + i));
  EXPECT_FALSE(board.Latest(oldest).has_value());
}

TEST(LiveBoardTest, WatchMayOutliveTheBoard) {
  auto board = std::make_unique<LiveBoard>();
  auto watch = board->Watch(Uuid::New(), Uuid{});
  board.reset();
  EXPECT_EQ(watch->Next(), nullptr);
}

TEST(LiveBoardTest, PuttingAndWatchingFromManyThreadsLosesNoEnd) {
  LiveBoard board;
  Uuid attempt = Uuid::New();
  std::vector<std::unique_ptr<LiveWatch>> watches;
  for (int i = 0; i < 4; ++i) watches.push_back(board.Watch(attempt, Uuid{}));
  std::vector<std::jthread> threads;
  for (auto& watch : watches) {
    threads.emplace_back([&watch] {
      while (!watch->ended()) {
        watch->Next();
        std::this_thread::yield();
      }
    });
  }
  for (uint64_t tick = 1; tick < 2000; ++tick) board.Put(Sample(attempt, tick));
  board.Remove(attempt);
  threads.clear();
  for (auto& watch : watches) EXPECT_TRUE(watch->ended());
}

}  // namespace
}  // namespace enamel::server
