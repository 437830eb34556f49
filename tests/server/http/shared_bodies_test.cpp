#include "server/http/shared_bodies.h"

#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <thread>
#include <vector>

// Large answers: in memory once, and shared out among those who read them.
namespace enamel::server::http {
namespace {

const Sha256 kName = HashSha256(AsBytes("a"));

TEST(SharedBodiesTest, WhatManyAskForIsReadOnceAndInMemoryOnce) {
  SharedBodies bodies;
  std::atomic<int> reads{0}, asking{0};
  std::vector<SharedBodies::Body> got(8);
  {
    std::vector<std::jthread> all;
    for (auto& body : got) {
      all.emplace_back([&] {
        ++asking;
        auto found = bodies.Get(kName, [&]() -> Result<Bytes> {
          ++reads;
          // The others come meanwhile.
          while (asking < 8) std::this_thread::yield();
          return Bytes(1000, 'x');
        });
        ASSERT_TRUE(found.ok());
        body = *found;
      });
    }
  }
  EXPECT_EQ(reads, 1);
  for (const auto& body : got) EXPECT_EQ(body, got[0]);
  got.clear();
  EXPECT_TRUE(bodies.Get(kName, [&]() -> Result<Bytes> { return ++reads, Bytes(); }).ok());
  EXPECT_EQ(reads, 2) << "nobody was sending it any more";
}

Sha256 NameOf(int i) { return HashSha256(AsBytes(std::to_string(i))); }

TEST(SharedBodiesTest, NoMoreAreMadeAtOnceThanItSays) {
  constexpr int kAsking = 6;
  SharedBodies bodies;
  std::atomic<int> asking{0}, making{0}, most{0}, made{0};
  {
    std::vector<std::jthread> all;
    for (int i = 0; i < kAsking; ++i) {
      all.emplace_back([&, i] {
        ++asking;
        const auto body = bodies.Made(NameOf(i), [&]() -> Result<Bytes> {
          const int now = ++making;
          for (int seen = most; seen < now && !most.compare_exchange_weak(seen, now);) {
          }
          // All others have come by then, and would be in here too.
          for (int turn = 0; asking < kAsking || turn < 2000; ++turn) std::this_thread::yield();
          --making;
          return Bytes(1, 'x');
        });
        made += body.ok();
      });
    }
  }
  EXPECT_EQ(most, static_cast<int>(SharedBodies::kMaxMade));
  EXPECT_EQ(made, kAsking) << "each in its turn";
}

TEST(SharedBodiesTest, WhoseTurnDoesNotComeIsToldToComeAgain) {
  SharedBodies bodies(std::chrono::milliseconds(0));
  std::atomic<size_t> making{0};
  std::atomic<bool> over{false};
  std::vector<std::jthread> all;
  for (int i = 0; i < static_cast<int>(SharedBodies::kMaxMade); ++i) {
    all.emplace_back([&, i] {
      EXPECT_TRUE(bodies
                      .Made(NameOf(i),
                            [&]() -> Result<Bytes> {
                              ++making;
                              while (!over) std::this_thread::yield();
                              return Bytes(1, 'x');
                            })
                      .ok());
    });
  }
  while (making < SharedBodies::kMaxMade) std::this_thread::yield();
  const auto late = bodies.Made(NameOf(9), [] { return Result<Bytes>(Bytes(1, 'x')); });
  EXPECT_EQ(late.status().code(), Code::kUnavailable);
  over = true;
  all.clear();
  EXPECT_TRUE(bodies.Made(NameOf(9), [] { return Result<Bytes>(Bytes(1, 'x')); }).ok());
}

TEST(SharedBodiesTest, WhatWasComputedStaysForAWhileAndAFailureDoesNot) {
  SharedBodies bodies;
  int made = 0;
  const auto make = [&]() -> Result<Bytes> {
    if (++made == 1) return Status(Code::kUnavailable, "no");
    return Bytes(1000, 'x');
  };
  EXPECT_FALSE(bodies.Made(kName, make).ok());
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(bodies.Made(kName, make).ok());
  EXPECT_EQ(made, 2);
  // Others take its room.
  for (size_t at = 0; at <= SharedBodies::kKeptBytes; at += 1 << 20) {
    const Sha256 name = HashSha256(AsBytes(std::to_string(at)));
    EXPECT_TRUE(bodies.Made(name, [] { return Result<Bytes>(Bytes(1 << 20)); }).ok());
  }
  EXPECT_TRUE(bodies.Made(kName, make).ok());
  EXPECT_EQ(made, 3);
}

TEST(SharedBodiesTest, OneFailedAllocationEndsOneReadAndNoOther) {
  SharedBodies bodies(std::chrono::milliseconds(20'000));
  const auto without_memory = []() -> Result<Bytes> { throw std::bad_alloc(); };
  const auto there = [] { return Result<Bytes>(Bytes{1}); };
  for (size_t i = 0; i < 2 * SharedBodies::kMaxMade; ++i) {
    EXPECT_THROW((void)bodies.Get(kName, without_memory), std::bad_alloc);
    EXPECT_THROW((void)bodies.Made(kName, without_memory), std::bad_alloc);
  }
  EXPECT_TRUE(bodies.Get(kName, there).ok());
  EXPECT_TRUE(bodies.Made(HashSha256(AsBytes("b")), there).ok());
}

}  // namespace
}  // namespace enamel::server::http
