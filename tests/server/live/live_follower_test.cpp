#include "server/live/live_follower.h"

#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <boost/json/value.hpp>

#include "common/trace/trace.h"
#include "tests/support/memory_store.h"

namespace enamel::server {
namespace {

// A server whose stations are elsewhere, and the store that it has in common with them.
class LiveFollowerTest : public ::testing::Test {
 protected:
  LiveFollowerTest() {
    row_.id = Uuid::New();
    row_.station = Uuid::New();
    row_.state = AttemptState::kRecording;
    store_.attempts[row_.id] = row_;
    store_.traces[row_.id] = {};
  }
  // Half a second of ticks, as its station commits them elsewhere.
  void Commit() {
    trace::ChunkHead head;
    head.attempt = row_.id;
    head.seq = chunks_;
    head.first_tick = uint64_t{chunks_++} * trace::kMaxTicksPerChunk;
    store_.traces[row_.id].chunks.push_back(trace::EncodeChunk(
        head, std::vector<trace::Tick>(trace::kMaxTicksPerChunk), key_.secret_key));
  }
  void Look() { follower_.Look(now_ms_ += 500); }
  size_t RowsOf(LiveWatch& watch) {
    const auto event = watch.Next();
    if (!event) return 0;
    const boost::json::value value = boost::json::parse(*event);
    newest_ = value.at("tick").to_number<uint64_t>();
    return value.at("rows").as_array().size();
  }

  test::MemoryStore store_;
  LiveBoard board_;
  LiveFollower follower_{board_, store_, LiveFollower::ByHand()};
  AttemptRow row_;
  const trace::KeyPair key_ = trace::NewKeyPair();
  uint32_t chunks_ = 0;
  UnixMs now_ms_ = 1'000'000;
  uint64_t newest_ = 0;
};

TEST_F(LiveFollowerTest, WatcherSeesWhatAnotherServerCommits) {
  Commit();
  Look();
  EXPECT_EQ(store_.newest_reads, 0) << "nobody watches";
  auto watch = board_.Watch(row_.id);
  size_t rows = 0;
  for (int i = 0; i < 20; ++i) {
    Commit();
    Look();
    rows += RowsOf(*watch);
  }
  EXPECT_EQ(newest_, uint64_t{chunks_} * trace::kMaxTicksPerChunk - 1) << "the newest tick of all";
  // Ten seconds.
  EXPECT_GE(rows, 500u);
  Look();
  EXPECT_EQ(watch->Next(), nullptr) << "nothing new";
}

TEST_F(LiveFollowerTest, OfAnAttemptThatIsFarOnlyTheNewestIsRead) {
  for (int i = 0; i < 40; ++i) Commit();
  auto watch = board_.Watch(row_.id);
  Look();
  EXPECT_GT(RowsOf(*watch), 0u);
  EXPECT_EQ(newest_, uint64_t{40} * trace::kMaxTicksPerChunk - 1);
}

TEST_F(LiveFollowerTest, WhatItsStationSaysHereIsNotReadAgain) {
  Commit();
  auto watch = board_.Watch(row_.id);
  LiveSample here;
  here.attempt = row_.id;
  for (int i = 0; i < 5; ++i) {
    here.tick += 400;
    here.received_ms = now_ms_ + 450;
    board_.Put(here);
    Look();
  }
  EXPECT_EQ(store_.newest_reads, 0);
  // It goes to another server, and comes back.
  for (int i = 0; i < 10; ++i) Commit();
  Look();
  Look();
  EXPECT_GT(store_.newest_reads, 0);
  EXPECT_GT(RowsOf(*watch), 0u);
  here.tick = newest_ + 400;
  here.received_ms = now_ms_ + 450;
  board_.Put(here);
  const int before = store_.newest_reads;
  Look();
  EXPECT_EQ(store_.newest_reads, before);
}

TEST_F(LiveFollowerTest, TheEndElsewhereIsTheEndHere) {
  Commit();
  auto watch = board_.Watch(row_.id), other = board_.Watch(Uuid::New());
  Look();
  (void)watch->Next();
  EXPECT_FALSE(watch->ended());
  store_.attempts[row_.id].state = AttemptState::kSealed;
  Look();
  (void)watch->Next();
  EXPECT_TRUE(watch->ended());
  (void)other->Next();
  EXPECT_TRUE(other->ended()) << "there is no such attempt any more";
}

}  // namespace
}  // namespace enamel::server
