#include "server/auth/first_admin.h"

#include <gtest/gtest.h>

namespace enamel::server::auth {
namespace {

constexpr UnixMs kNow = 1'700'000'000'000;

TEST(FirstAdminTest, TokenIsGoodOnceAndUntilItRunsOut) {
  FirstAdmin first;
  EXPECT_FALSE(first.Take("", kNow).ok()) << "none was offered";
  const std::string token = first.Offer(kNow);
  EXPECT_EQ(token.size(), 64u);
  EXPECT_EQ(first.Take(token, kNow + FirstAdmin::kGoodMs).code(), Code::kForbidden);
  ASSERT_TRUE(first.Take(token, kNow + FirstAdmin::kGoodMs - 1).ok());
  EXPECT_EQ(first.Take(token, kNow).field(), "token") << "used";
  first.GiveBack();
  EXPECT_TRUE(first.Take(token, kNow).ok()) << "it made no account";
}

TEST(FirstAdminTest, NewOfferEndsTheOneBefore) {
  FirstAdmin first;
  const std::string before = first.Offer(kNow), now = first.Offer(kNow);
  EXPECT_NE(before, now);
  EXPECT_FALSE(first.Take(before, kNow).ok());
  EXPECT_TRUE(first.Take(now, kNow).ok());
}

TEST(FirstAdminTest, WhoGuessesEndsIt) {
  FirstAdmin first;
  const std::string token = first.Offer(kNow);
  for (uint32_t i = 0; i < FirstAdmin::kMaxWrong; ++i) {
    EXPECT_FALSE(first.Take(std::string(64, 'a'), kNow).ok());
  }
  EXPECT_FALSE(first.Take(token, kNow).ok());
}

}  // namespace
}  // namespace enamel::server::auth
