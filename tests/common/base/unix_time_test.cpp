#include "common/base/unix_time.h"

#include <gtest/gtest.h>

#include "common/base/uuid.h"

namespace enamel {
namespace {

using std::chrono::hours;
using std::chrono::system_clock;

class UnixTimeTest : public ::testing::Test {
 protected:
  ~UnixTimeTest() override { FollowSystemClock(); }
};

TEST_F(UnixTimeTest, IsTheSystemsUntilAnotherIsFollowed) {
  const auto before = system_clock::now();
  const auto here = WallClock();
  EXPECT_LE(before, here);
  EXPECT_LE(here, system_clock::now());
}

TEST_F(UnixTimeTest, FollowedClockGoesOnFromWhereItWas) {
  const auto theirs = system_clock::now() - hours(24);
  const auto asked = system_clock::now();
  FollowClock(theirs);
  const auto first = WallClock();
  const auto second = WallClock();
  EXPECT_LE(theirs, first);
  EXPECT_LE(first, second);
  // A day before, plus the time that passed on this machine, or this machine's clock was set.
  EXPECT_LE(first - theirs, system_clock::now() - asked + hours(1));
  EXPECT_LT(UnixMs(), UnixMs(system_clock::now()) - 23 * 3600 * 1000);
  EXPECT_LT(Uuid::New(), Uuid::New(system_clock::now() - hours(1))) << "ids sort by the same times";
  FollowSystemClock();
  EXPECT_LE(asked, WallClock());
}

}  // namespace
}  // namespace enamel
