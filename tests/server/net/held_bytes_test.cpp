#include "server/net/held_bytes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <vector>

namespace enamel::server {
namespace {

// Some answers of one person, and how many of them were given up.
struct Answers {
  std::vector<std::shared_ptr<HeldBytes::Held>> sending;
  std::atomic<int> given_up{0};

  bool Add(HeldBytes& unsent, const std::string& of, const void* body, size_t bytes) {
    auto one = unsent.Add(of, body, bytes);
    if (one == nullptr) return false;
    one->OnGivenUp([this] { ++given_up; });
    sending.push_back(std::move(one));
    return true;
  }
};

TEST(HeldBytesTest, WhoHoldsMostMakesRoomForWhoHoldsLess) {
  HeldBytes unsent(1000);
  Answers slow, other;
  const std::vector<char> bodies(100);
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(slow.Add(unsent, "slow", &bodies[i], 100));
  EXPECT_FALSE(slow.Add(unsent, "slow", &bodies[10], 100)) << "nobody holds more";
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(other.Add(unsent, "other", &bodies[20 + i], 100));
  EXPECT_EQ(slow.given_up, 5);
  EXPECT_EQ(other.given_up, 0);
  EXPECT_FALSE(other.Add(unsent, "other", &bodies[30], 100)) << "as much as anybody";
  EXPECT_EQ(unsent.bytes(), 1000u);
  EXPECT_EQ(unsent.refused(), 7u);
  EXPECT_EQ(unsent.Most("o").of, "other");
  EXPECT_EQ(unsent.Most("o").bytes, 500u);
  slow.sending.clear();
  other.sending.clear();
  EXPECT_EQ(unsent.bytes(), 0u);
  EXPECT_EQ(unsent.Most().of, "");
}

TEST(HeldBytesTest, OneBodyCountsOnceHoweverManyReadIt) {
  HeldBytes unsent(1000);
  Answers all;
  const char body = 0, another = 0;
  for (int i = 0; i < 40; ++i) {
    EXPECT_TRUE(all.Add(unsent, "student " + std::to_string(i), &body, 900));
  }
  EXPECT_EQ(unsent.bytes(), 900u);
  EXPECT_FALSE(all.Add(unsent, "late", &another, 900));
  EXPECT_EQ(all.given_up, 0);
}

TEST(HeldBytesTest, AnAnswerThatIsGivenUpBeforeItIsSentIsClosedAtOnce) {
  HeldBytes unsent(100);
  const char body = 0, another = 0, third = 0;
  const auto first = unsent.Add("slow", &body, 60), second = unsent.Add("slow", &another, 40);
  EXPECT_NE(unsent.Add("other", &third, 50), nullptr);
  bool closed = false;
  first->OnGivenUp([&] { closed = true; });
  EXPECT_TRUE(closed);
}

}  // namespace
}  // namespace enamel::server
