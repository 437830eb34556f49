#include "server/jobs/tick_window.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cmath>

#include "tests/server/jobs/recorded_attempt.h"

namespace enamel::server {
namespace {

namespace json = boost::json;
using test::World;

class TickWindowTest : public ::testing::Test {
 protected:
  static std::vector<Bytes> Recorded(const test::PathOptions& path = {}) {
    return World::Get().Record(Uuid::New(), Uuid::New(), path).chunks;
  }
  static json::object Window(const std::vector<Bytes>& chunks, uint64_t from, uint64_t to) {
    auto text = TickWindowJson(trace::EachOf(chunks), from, to);
    EXPECT_TRUE(text.ok()) << text.status().message();
    return json::parse(text.ok() ? *text : "{}").as_object();
  }
};

TEST_F(TickWindowTest, SaysWhatWasRecordedOfEachTick) {
  const auto chunks = Recorded({.late = true});
  std::vector<trace::Tick> ticks;
  for (const Bytes& chunk : chunks) {
    const auto decoded = trace::DecodeChunk(chunk);
    ticks.insert(ticks.end(), decoded->ticks.begin(), decoded->ticks.end());
  }
  ASSERT_GT(ticks.size(), 1500u);
  // Over the border of two chunks.
  const json::object window = Window(chunks, 400, 1400);
  ASSERT_EQ(window.at("time_ticks").as_array().size(), 1000u);
  double largest = 0;
  for (size_t i = 0; i < 1000; ++i) {
    const trace::Tick& tick = ticks[400 + i];
    const auto& f = core::PressedForce_mn(tick.witness);
    const double newton =
        1e-3 * std::sqrt(double(f[0]) * f[0] + double(f[1]) * f[1] + double(f[2]) * f[2]);
    ASSERT_EQ(window.at("time_ticks").at(i).to_number<uint64_t>(), 400 + i);
    ASSERT_NEAR(window.at("force_n").at(i).to_number<double>(), newton, 0.6e-3) << i;
    ASSERT_EQ(window.at("late").at(i).as_int64(), (tick.input.flags & core::kLateTick) != 0);
    largest = std::max(largest, newton);
  }
  EXPECT_GT(largest, 0.01) << "the bur touched in that span";
}

TEST_F(TickWindowTest, TimeGoesOnInAGap) {
  const auto chunks = Recorded({.gap_ticks = 300});
  const json::array all = Window(chunks, 0, 4000).at("time_ticks").as_array();
  uint64_t before = 0, widest = 0, recorded = 0;
  for (uint64_t from = 0;; from += 4000) {
    const json::array part = Window(chunks, from, from + 4000).at("time_ticks").as_array();
    if (part.empty()) break;
    for (const json::value& v : part) {
      const auto at = v.to_number<uint64_t>();
      widest = std::max(widest, at - before);
      before = at;
    }
    recorded += part.size();
  }
  EXPECT_EQ(widest, 301u);
  EXPECT_EQ(before + 1, recorded + 300) << "each tick is in one window";
}

TEST_F(TickWindowTest, ASpanThatIsEmptyOrTooLongIsRefused) {
  const std::vector<Bytes> none;
  for (const auto& [from, to] : std::vector<std::pair<uint64_t, uint64_t>>{
           {5, 5}, {5, 4}, {0, 4001}, {~uint64_t{0}, 3999}}) {
    const auto window = TickWindowJson(trace::EachOf(none), from, to);
    ASSERT_FALSE(window.ok()) << from << " to " << to;
    EXPECT_EQ(window.status().code(), Code::kInvalidInput);
    EXPECT_EQ(window.status().field(), "to");
  }
  EXPECT_TRUE(Window(none, 7, 8).at("force_n").as_array().empty());
}

TEST_F(TickWindowTest, WhatIsNoChunkIsSaid) {
  const std::vector<Bytes> chunks{Bytes(40, 1)};
  EXPECT_FALSE(TickWindowJson(trace::EachOf(chunks), 0, 10).ok());
}

}  // namespace
}  // namespace enamel::server
