#include "station/uplink/backoff.h"

#include <gtest/gtest.h>

#include <set>

namespace enamel::station {
namespace {

using std::chrono::milliseconds;

TEST(BackoffTest, DoublesFromHalfASecondToThirtyEachShortenedByAtMostHalf) {
  for (uint32_t seed = 1; seed <= 50; ++seed) {
    Backoff backoff(seed);
    for (int full_ms : {500, 1000, 2000, 4000, 8000, 16'000, 30'000, 30'000, 30'000}) {
      auto wait = backoff.Next();
      EXPECT_LE(wait, milliseconds(full_ms)) << seed;
      EXPECT_GE(wait, milliseconds(full_ms / 2)) << seed;
    }
    backoff.Reset();
    EXPECT_LE(backoff.Next(), milliseconds(500));
  }
}

// Forty stations that lost their server at the same moment return spread over the whole span.
TEST(BackoffTest, StationsOfARoomDoNotComeBackAtOnce) {
  std::set<int64_t> tenths;
  for (uint32_t station = 1; station <= 40; ++station) {
    Backoff backoff(station * 2'654'435'761u);
    milliseconds at{0};
    for (int i = 0; i < 5; ++i) at += backoff.Next();
    EXPECT_GE(at, milliseconds(15'500 / 2));
    EXPECT_LE(at, milliseconds(15'500));
    tenths.insert(at.count() / 100);
  }
  EXPECT_GE(tenths.size(), 20u);
}

}  // namespace
}  // namespace enamel::station
