#include "server/stations/arrivals.h"

#include <gtest/gtest.h>

namespace enamel::server::stations {
namespace {

TEST(ArrivalsTest, ARecordingIsLateAfterFiveSecondsAndGoneAfterAMinute) {
  Arrivals arrivals;
  const Uuid steady = Uuid::New(), slow = Uuid::New();
  arrivals.Came(slow, 1'000);
  arrivals.Came(steady, 1'000);
  const auto counts = [&](UnixMs now) {
    const Arrivals::Counts found = arrivals.Count(now);
    return std::pair(found.coming, found.late);
  };
  using Pair = std::pair<size_t, size_t>;
  EXPECT_EQ(counts(6'000), Pair(2, 0));
  EXPECT_EQ(counts(6'001), Pair(2, 2));
  arrivals.Came(steady, 60'000);
  EXPECT_EQ(counts(61'000), Pair(2, 1));
  EXPECT_EQ(counts(61'001), Pair(1, 0));
  arrivals.Came(slow, 62'000);
  EXPECT_EQ(counts(62'000), Pair(2, 0)) << "it has come back";
  arrivals.Ended(steady);
  EXPECT_EQ(counts(62'000), Pair(1, 0));
}

TEST(ArrivalsTest, OnlySoManyAreRemembered) {
  Arrivals arrivals;
  for (size_t i = 0; i < Arrivals::kMost + 10; ++i) arrivals.Came(Uuid::New(), 1'000);
  EXPECT_EQ(arrivals.Count(1'000).coming, Arrivals::kMost);
}

TEST(ArrivalsTest, FiguresSayHowLongChunksTook) {
  Arrivals arrivals;
  arrivals.Answered(std::chrono::milliseconds(3));
  ops::MetricsText text;
  arrivals.AddFigures(text, 0);
  const std::string said = text.Take();
  EXPECT_NE(said.find("enamel_ingest_lag_seconds_bucket{le=\"0.0025\"} 0\n"), std::string::npos)
      << said;
  EXPECT_NE(said.find("enamel_ingest_lag_seconds_bucket{le=\"0.005\"} 1\n"), std::string::npos)
      << said;
  EXPECT_NE(said.find("enamel_recordings_late 0\n"), std::string::npos) << said;
}

}  // namespace
}  // namespace enamel::server::stations
