#include "server/auth/device_tokens.h"

#include <gtest/gtest.h>

namespace enamel::server::auth {
namespace {

class DeviceTokensTest : public ::testing::Test {
 protected:
  static constexpr UnixMs kNow = 1'800'000'000'000, kDayMs = 24 * 60 * 60 * 1000;
  DeviceTokens tokens_{DataKey::New()};
};

TEST_F(DeviceTokensTest, NameALoginThatSignedInAndNoOther) {
  const std::string kept = tokens_.With("ada", "", kNow);
  EXPECT_EQ(tokens_.NameFor("ada", kept, kNow).size(), 16u);
  EXPECT_EQ(tokens_.NameFor("ben", kept, kNow), "");
  EXPECT_EQ(DeviceTokens(DataKey::New()).NameFor("ada", kept, kNow), "") << "another school's key";
}

TEST_F(DeviceTokensTest, LastAMonthFromTheLastSignInUnderOneName) {
  const std::string first = tokens_.With("ada", "", kNow);
  const std::string name = tokens_.NameFor("ada", first, kNow);
  EXPECT_EQ(tokens_.NameFor("ada", first, kNow + 29 * kDayMs), name);
  EXPECT_EQ(tokens_.NameFor("ada", first, kNow + 30 * kDayMs), "");
  const std::string next = tokens_.With("ada", first, kNow + 20 * kDayMs);
  EXPECT_EQ(next.size(), first.size());
  EXPECT_EQ(tokens_.NameFor("ada", next, kNow + 49 * kDayMs), name);
}

TEST_F(DeviceTokensTest, AreKeptForTheLastFiveLogins) {
  std::string kept;
  for (const char* login : {"a", "b", "c", "d", "e", "f"}) kept = tokens_.With(login, kept, kNow);
  EXPECT_EQ(tokens_.NameFor("a", kept, kNow), "");
  for (const char* login : {"b", "c", "d", "e", "f"}) {
    EXPECT_NE(tokens_.NameFor(login, kept, kNow), "") << login;
  }
  EXPECT_EQ(kept.size(), 5 * 57 - 1u);
}

TEST_F(DeviceTokensTest, OtherTextIsIgnored) {
  const std::string kept = tokens_.With("ada", "", kNow);
  for (size_t i = 0; i < kept.size(); ++i) {
    std::string changed = kept;
    changed[i] = changed[i] == '0' ? '1' : '0';
    EXPECT_EQ(tokens_.NameFor("ada", changed, kNow), "") << i;
  }
  const std::string long_one(100'000, 'x');
  EXPECT_EQ(tokens_.NameFor("ada", long_one, kNow), "");
  EXPECT_EQ(tokens_.With("ada", long_one, kNow).size(), kept.size());
}

}  // namespace
}  // namespace enamel::server::auth
