#include "server/auth/throttle.h"

#include <gtest/gtest.h>

namespace enamel::server::auth {
namespace {

constexpr char kHere[] = "203.0.113.7";
constexpr char kElsewhere[] = "198.51.100.9";

void Fail(Throttle& throttle, const std::string& login, const std::string& address, int times,
          UnixMs now) {
  for (int i = 0; i < times; ++i) throttle.Failed(login, address, now);
}

TEST(ThrottleTest, FirstFailuresCostNothing) {
  Throttle throttle;
  Fail(throttle, "ada", kHere, 5, 1000);
  EXPECT_TRUE(throttle.Check("ada", kHere, 1000).ok());
}

TEST(ThrottleTest, DelayDoublesUpToAMinuteAndThenEndsByItself) {
  Throttle throttle;
  Fail(throttle, "ada", kHere, 6, 1000);
  EXPECT_EQ(throttle.Check("ada", kHere, 1400).field(), "throttled");
  EXPECT_TRUE(throttle.Check("ada", kHere, 1500).ok());
  Fail(throttle, "ada", kHere, 14, 2000);
  EXPECT_FALSE(throttle.Check("ada", kHere, 2000 + 59'999).ok());
  EXPECT_TRUE(throttle.Check("ada", kHere, 2000 + 60'000).ok());
}

TEST(ThrottleTest, StrangerDelaysTheOwnerElsewhereByFourSecondsAtMost) {
  Throttle throttle;
  Fail(throttle, "ada", kHere, 1000, 1000);
  EXPECT_TRUE(throttle.Check("ada", kElsewhere, 1000 + 4'000).ok());
  EXPECT_FALSE(throttle.Check("ada", kHere, 1000 + 4'000).ok());
}

TEST(ThrottleTest, GuessingManyLoginsFromOneBlockIsSlowed) {
  Throttle throttle;
  for (int i = 0; i < 40; ++i) throttle.Failed("login" + std::to_string(i), kHere, 1000);
  EXPECT_FALSE(throttle.Check("another", "203.0.113.99", 1000).ok());
  EXPECT_TRUE(throttle.Check("another", kElsewhere, 1000).ok());
}

TEST(ThrottleTest, SuccessAndSilenceAreForgiven) {
  Throttle throttle;
  Fail(throttle, "ada", kHere, 10, 1000);
  throttle.Succeeded("ada", kHere);
  EXPECT_TRUE(throttle.Check("ada", kHere, 1000).ok());
  Fail(throttle, "bob", kHere, 10, 1000);
  Fail(throttle, "bob", kHere, 1, 1000 + 16 * 60 * 1000);
  EXPECT_TRUE(throttle.Check("bob", kHere, 1000 + 16 * 60 * 1000).ok());
}

TEST(ThrottleTest, AddressesAreTakenByBlock) {
  EXPECT_EQ(AddressBlock("203.0.113.7"), "203.0.113.0/24");
  EXPECT_EQ(AddressBlock("2001:db8:1:2:3::4"), "2001:db8:1:2::/64");
  EXPECT_EQ(AddressBlock("unknown"), "unknown");
}

}  // namespace
}  // namespace enamel::server::auth
