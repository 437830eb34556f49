#include "server/stations/link_budget.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <vector>

namespace enamel::server::stations {
namespace {

constexpr UnixMs kDayMs = 86'400'000;

TEST(LinkBudgetTest, WhatAStationRecordsInADayIsBoundedForItAlone) {
  LinkBudget budget;
  const StationOfSchool one{nullptr, Uuid::New()}, other{nullptr, Uuid::New()};
  const uint64_t quarter = ops::LimitOf(ops::kStationRecordings, {}) / 4;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(budget.Recorded(one, quarter, kDayMs + i));
  EXPECT_FALSE(budget.Recorded(one, 1, kDayMs + 5));
  EXPECT_TRUE(budget.Recorded(other, quarter, kDayMs + 5));
  EXPECT_FALSE(budget.Recorded(one, 1, 2 * kDayMs - 1));
  EXPECT_TRUE(budget.Recorded(one, 1, 2 * kDayMs)) << "the next day";
}

TEST(LinkBudgetTest, AStationThatTakesMoreThanItsShareRestsAndOthersDoNot) {
  using namespace std::chrono_literals;
  LinkBudget budget;
  const StationOfSchool one{nullptr, Uuid::New()}, other{nullptr, Uuid::New()};
  const LinkBudget::Clock::time_point begin{};
  auto now = begin;
  LinkBudget::Clock::duration took{}, longest{};
  // Eight connections that each ask again as soon as they may.
  while (now < begin + 60s) {
    LinkBudget::Clock::duration rest{};
    for (int i = 0; i < 8; ++i) {
      took += 2ms;
      rest = std::max(rest, budget.Took(one, 2ms, now));
    }
    longest = std::max(longest, rest);
    now += 2ms + rest;
  }
  EXPECT_NEAR(std::chrono::duration<double>(took).count(),
              60 * ops::Budgets{}.station_time_percent / 100, 1.5);
  EXPECT_LE(longest, LinkBudget::kLongestRest);
  EXPECT_EQ(budget.Took(other, 2ms, now), 0s);
  EXPECT_EQ(budget.Took(one, 2ms, now + 60s), 0s) << "what was owed is not kept for ever";
}

TEST(LinkBudgetTest, FramesThatHaveOnlyBegunAreBoundedAndTheirStationPaysForThem) {
  LinkBudget budget;
  constexpr size_t kFrame = size_t{4} << 20;
  std::vector<std::shared_ptr<HeldBytes::Held>> coming;
  std::vector<char> where(64);
  int closed = 0;
  for (char& at : where) {
    auto one = budget.Coming("stolen", &at, kFrame);
    if (one == nullptr) continue;
    one->OnGivenUp([&] { ++closed; });
    coming.push_back(std::move(one));
  }
  EXPECT_EQ(coming.size(), ops::LimitOf(ops::kStationFrames, {}) / kFrame);
  const char at = 0;
  EXPECT_NE(budget.Coming("another", &at, kFrame), nullptr);
  EXPECT_EQ(closed, 1);
}

TEST(LinkBudgetTest, UseIsOfTheStationThatUsesMostOfItsOwnSchool) {
  ops::Budgets limits;
  limits.station_recordings_mib = 16;
  LinkBudget budget(limits);
  const auto* const school = reinterpret_cast<const Services*>(&limits);
  const StationOfSchool one{school, Uuid::New()}, two{school, Uuid::New()},
      other{nullptr, one.second};
  EXPECT_TRUE(budget.Recorded(one, 1000, kDayMs));
  EXPECT_TRUE(budget.Recorded(two, 2000, kDayMs));
  EXPECT_TRUE(budget.Recorded(other, 3000, kDayMs));
  EXPECT_FALSE(budget.Recorded(other, 16 << 20, kDayMs));
  const char frame = 0;
  const auto held = budget.Coming(LinkBudget::PartyOf(two), &frame, 70'000);
  std::map<std::string_view, ops::BudgetUse> uses;
  for (const ops::BudgetUse& use : budget.Uses(school, kDayMs)) uses[use.kind->name] = use;
  const ops::BudgetUse& recorded = uses["station_recordings_mib"];
  EXPECT_EQ(recorded.limit, size_t{16} << 20);
  EXPECT_EQ(recorded.most, 2000u);
  EXPECT_EQ(recorded.of, two.second.Text());
  EXPECT_EQ(recorded.refused, 1u);
  EXPECT_EQ(uses["station_frames_mib"].most, 70'000u);
  EXPECT_EQ(uses["station_frames_mib"].of, two.second.Text());
  EXPECT_EQ(uses["station_links"].party, ops::PartyKind::kNone);
  for (const ops::BudgetUse& use : budget.Uses(school, 3 * kDayMs)) uses[use.kind->name] = use;
  EXPECT_EQ(uses["station_recordings_mib"].most, 0u) << "of the day before";
}

}  // namespace
}  // namespace enamel::server::stations
