#include "server/storage/upkeep/readiness.h"

#include <gtest/gtest.h>

namespace enamel::server {
namespace {

StoreHealth Failing() {
  StoreHealth out;
  out.takes_recordings = false;
  out.problem = "the database server does not answer";
  out.database_fails = true;
  return out;
}

TEST(ReadinessTest, ATroubleOfTheDatabaseCountsAgainstAServerUnlessAllOthersHaveItToo) {
  EXPECT_EQ(ReadinessOf({}, PeersView{}), Readiness::kReady);
  const StoreHealth failing = Failing();
  EXPECT_EQ(ReadinessOf(failing, std::nullopt), Readiness::kDegraded) << "not asked yet";
  EXPECT_EQ(ReadinessOf(failing, PeersView{}), Readiness::kNoRecordings) << "there is no other";
  EXPECT_EQ(ReadinessOf(failing, PeersView{.asked = 2}), Readiness::kNoRecordings)
      << "cut off from everybody";
  EXPECT_EQ(ReadinessOf(failing, PeersView{.asked = 2, .answered = 2, .database = 1}),
            Readiness::kNoRecordings);
  EXPECT_EQ(ReadinessOf(failing, PeersView{.asked = 3, .answered = 2, .database = 2}),
            Readiness::kDegraded);
}

TEST(ReadinessTest, WhatIsThisMachinesOwnIsNeverDegraded) {
  StoreHealth full = Failing();
  full.database_fails = false;  // the disk of its folder
  const PeersView all{.asked = 1, .answered = 1, .database = 1};
  EXPECT_EQ(ReadinessOf(full, all), Readiness::kNoRecordings);
  StoreHealth off;
  off.clock_is_off = true;
  EXPECT_EQ(ReadinessOf(off, all), Readiness::kClockOff);
}

TEST(ReadinessTest, AStoreThatOnlyThisServerCannotUseIsLeftToTheOthers) {
  StoreHealth health;
  health.waiting = "the store of blobs cannot be written or read";
  health.blobs_fail = true;
  EXPECT_EQ(ReadinessOf(health, std::nullopt), Readiness::kDegraded);
  EXPECT_EQ(ReadinessOf(health, PeersView{.asked = 1}), Readiness::kDegraded);
  EXPECT_EQ(ReadinessOf(health, PeersView{.asked = 2, .answered = 2, .blobs = 1}),
            Readiness::kNoRecordings);
  EXPECT_EQ(ReadinessOf(health, PeersView{.asked = 2, .answered = 2, .blobs = 2}),
            Readiness::kDegraded);
}

}  // namespace
}  // namespace enamel::server
