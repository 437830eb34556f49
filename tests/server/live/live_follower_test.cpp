#include "server/live/live_follower.h"

#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>

#include "common/trace/trace.h"
#include "tests/server/storage/store_world.h"

namespace enamel::server {
namespace {

// A server whose stations are elsewhere, and the store that they share.
class LiveFollowerTest : public ::testing::Test {
 protected:
  // So many seconds of ticks, as its station commits them elsewhere.
  void Commit(int seconds = 1) {
    for (int i = 0; i < seconds; ++i, ++seal_.chunks, seal_.ticks += trace::kMaxTicksPerChunk) {
      const trace::ChunkHead head{.attempt = attempt_,
                                  .seq = seal_.chunks,
                                  .first_tick = seal_.ticks,
                                  .previous = seal_.last_chunk};
      Bytes bytes = trace::EncodeChunk(head, std::vector<trace::Tick>(trace::kMaxTicksPerChunk),
                                       world_.keys.secret_key);
      const auto decoded = *trace::DecodeChunkHead(bytes);
      seal_.last_chunk = decoded.hash;
      const Status added =
          store_->ingest.AppendChunk({attempt_, decoded.head, decoded.hash, std::move(bytes), 100});
      ASSERT_TRUE(added.ok()) << added.message();
    }
  }
  void Look() { follower_.Look(now_ms_ += 500); }
  size_t RowsOf(LiveWatch& watch) {
    const auto event = watch.Next();
    if (!event) return 0;
    const boost::json::value value = boost::json::parse(*event);
    newest_ = value.at("tick").to_number<uint64_t>();
    return value.at("rows").as_array().size();
  }

  server::testing::TempFolder folder_;
  std::unique_ptr<Store> store_ = server::testing::OpenStore(folder_.path());
  server::testing::World world_{*store_};
  const Uuid attempt_ = world_.OpenedAttempt();
  LiveBoard board_;
  LiveFollower follower_{board_, *store_, LiveFollower::ByHand()};
  // Of the committed chunks.
  trace::Seal seal_{attempt_, 0, 0, server::testing::World::HeaderHash(), 0};
  UnixMs now_ms_ = 1'000'000;
  uint64_t newest_ = 0;
};

TEST_F(LiveFollowerTest, WatcherSeesWhatAnotherServerCommits) {
  Commit();
  Look();
  EXPECT_FALSE(board_.Latest(attempt_)) << "nobody watches: nothing is read";
  auto watch = board_.Watch(attempt_, Uuid{});
  size_t rows = 0;
  for (int i = 0; i < 20; ++i) {
    Commit();
    Look();
    rows += RowsOf(*watch);
  }
  EXPECT_EQ(newest_, seal_.ticks - 1) << "the newest tick of all";
  // Ten seconds.
  EXPECT_GE(rows, 500u);
  Look();
  EXPECT_EQ(watch->Next(), nullptr) << "nothing new";
}

TEST_F(LiveFollowerTest, OfAnAttemptThatIsFarOnlyTheNewestIsRead) {
  Commit(40);
  auto watch = board_.Watch(attempt_, Uuid{});
  Look();
  EXPECT_GT(RowsOf(*watch), 0u);
  EXPECT_EQ(newest_, seal_.ticks - 1);
}

TEST_F(LiveFollowerTest, WhatItsStationSaysHereIsNotReadAgain) {
  Commit(10);
  auto watch = board_.Watch(attempt_, Uuid{});
  LiveSample here;
  here.attempt = attempt_;
  for (int i = 0; i < 5; ++i) {
    here.tick += 400;
    here.received_ms = now_ms_ + 450;
    board_.Put(here);
    Look();
  }
  EXPECT_EQ(board_.Latest(attempt_)->tick, here.tick) << "and not the newest that is committed";
  // It goes to another server, and comes back.
  Look();
  Look();
  EXPECT_GT(RowsOf(*watch), 0u);
  EXPECT_EQ(newest_, seal_.ticks - 1);
  here.tick = newest_ + 400;
  here.received_ms = now_ms_ + 450;
  board_.Put(here);
  Commit();
  Look();
  EXPECT_EQ(board_.Latest(attempt_)->tick, here.tick);
}

TEST_F(LiveFollowerTest, TheEndElsewhereIsTheEndHere) {
  Commit();
  auto watch = board_.Watch(attempt_, Uuid{}), other = board_.Watch(Uuid::New(), Uuid{});
  Look();
  (void)watch->Next();
  EXPECT_FALSE(watch->ended());
  ASSERT_TRUE(store_->seals.SealAttempt(seal_, 200).ok());
  Look();
  (void)watch->Next();
  EXPECT_TRUE(watch->ended());
  (void)other->Next();
  EXPECT_TRUE(other->ended()) << "there is no such attempt any more";
}

}  // namespace
}  // namespace enamel::server
