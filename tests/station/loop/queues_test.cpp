#include <gtest/gtest.h>

#include <thread>

#include "common/base/triple_buffer.h"
#include "station/loop/spsc_ring.h"

namespace enamel::station {
namespace {

TEST(SpscRingTest, RefusesWhatDoesNotFitAndLosesNothing) {
  SpscRing<int> ring(3);
  EXPECT_TRUE(ring.Push(1) && ring.Push(2) && ring.Push(3));
  EXPECT_TRUE(ring.Full());
  EXPECT_FALSE(ring.Push(4));
  EXPECT_EQ(ring.size(), 3u);
  int v = 0;
  for (int want : {1, 2, 3}) {
    ASSERT_TRUE(ring.Pop(v));
    EXPECT_EQ(v, want);
  }
  EXPECT_FALSE(ring.Pop(v));
  EXPECT_EQ(v, 3);
}

TEST(SpscRingTest, KeepsOrderBetweenTwoThreads) {
  constexpr int kCount = 200'000;
  SpscRing<int> ring(64);
  std::thread producer([&] {
    for (int i = 0; i < kCount;) {
      if (ring.Push(i))
        ++i;
      else
        std::this_thread::yield();
    }
  });
  int wrong = 0;
  for (int want = 0; want < kCount;) {
    int v = -1;
    if (!ring.Pop(v)) {
      std::this_thread::yield();
      continue;
    }
    wrong += v != want;
    ++want;
  }
  producer.join();
  EXPECT_EQ(wrong, 0);
}

struct Pair {
  uint64_t a = 0, b = 0;
};

TEST(TripleBufferTest, ReaderSeesWholeValuesThatNeverGoBack) {
  TripleBuffer<Pair> buffer;
  EXPECT_EQ(buffer.Read().a, 0u);
  std::thread writer([&] {
    for (uint64_t i = 1; i <= 100'000; ++i) buffer.Write({i, ~i});
  });
  uint64_t last = 0;
  int torn = 0, back = 0;
  while (last < 100'000) {
    const Pair& p = buffer.Read();
    if (p.a == 0) continue;
    torn += p.b != ~p.a;
    back += p.a < last;
    last = p.a;
  }
  writer.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(back, 0);
}

}  // namespace
}  // namespace enamel::station
