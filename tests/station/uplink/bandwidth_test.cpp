#include "station/uplink/bandwidth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace enamel::station {
namespace {

using Clock = Bandwidth::Clock;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr uint64_t kRate = 10'000;

// Sends messages of random sizes as early as allowed; returns the amount sent by each moment.
struct Sent {
  Clock::time_point at;
  size_t bytes;
};
std::vector<Sent> SendAll(Bandwidth& bandwidth, Clock::time_point start, int messages,
                          size_t largest) {
  std::minstd_rand random(7);
  std::vector<Sent> out;
  auto now = start;
  for (int i = 0; i < messages; ++i) {
    size_t bytes = 1 + random() % largest;
    while (true) {
      auto wait = bandwidth.Take(bytes, now);
      if (wait == Clock::duration{}) break;
      EXPECT_GT(wait, Clock::duration{});
      now += wait;
    }
    out.push_back({now, bytes});
  }
  return out;
}

TEST(BandwidthTest, NoSpanOfTimeSeesMoreThanItsShareAndOneBucketAndOneMessage) {
  for (size_t largest : {100u, 4'000u, 35'000u}) {
    Bandwidth bandwidth(kRate);
    auto sent = SendAll(bandwidth, Clock::now(), 400, largest);
    for (size_t from = 0; from < sent.size(); from += 7) {
      double bytes = 0;
      for (size_t to = from; to < sent.size(); ++to) {
        bytes += static_cast<double>(sent[to].bytes);
        double span_s = std::chrono::duration<double>(sent[to].at - sent[from].at).count();
        ASSERT_LE(bytes, kRate * (span_s + 1) + static_cast<double>(largest) + 1)
            << from << ".." << to << " with messages up to " << largest;
      }
    }
  }
}

TEST(BandwidthTest, InTheLongRunTheRateIsUsed) {
  Bandwidth bandwidth(kRate);
  auto start = Clock::now();
  auto sent = SendAll(bandwidth, start, 2'000, 3'000);
  double bytes = 0;
  for (const Sent& s : sent) bytes += static_cast<double>(s.bytes);
  double span_s = std::chrono::duration<double>(sent.back().at - start).count();
  EXPECT_NEAR(bytes / span_s, kRate, kRate * 0.01);
}

TEST(BandwidthTest, WhatMayBeDroppedLeavesHalfTheBucket) {
  Bandwidth bandwidth(kRate);
  auto now = Clock::now();
  size_t spare = 0;
  while (bandwidth.TakeSpare(100, now)) spare += 100;
  EXPECT_EQ(spare, kRate / 2);
  EXPECT_EQ(bandwidth.Take(kRate / 2, now), Clock::duration{});
  EXPECT_GT(bandwidth.Take(100, now), Clock::duration{});
  EXPECT_FALSE(bandwidth.TakeSpare(1, now + milliseconds(400)));
  EXPECT_TRUE(bandwidth.TakeSpare(1, now + milliseconds(600)));
}

TEST(BandwidthTest, AnHourOfSilenceIsWorthOneSecond) {
  Bandwidth bandwidth(kRate);
  auto now = Clock::now();
  EXPECT_EQ(bandwidth.Take(kRate, now), Clock::duration{});
  now += seconds(3600);
  EXPECT_EQ(bandwidth.Take(kRate, now), Clock::duration{});
  EXPECT_GT(bandwidth.Take(1'000, now), milliseconds(99));
}

TEST(BandwidthTest, WithoutABoundNothingWaits) {
  Bandwidth bandwidth(0);
  EXPECT_EQ(bandwidth.Take(size_t{1} << 40, Clock::now()), Clock::duration{});
  EXPECT_TRUE(bandwidth.TakeSpare(size_t{1} << 40, Clock::now()));
}

}  // namespace
}  // namespace enamel::station
