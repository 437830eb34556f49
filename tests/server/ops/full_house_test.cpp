#include "server/ops/full_house.h"

#include <gtest/gtest.h>

namespace enamel::server::ops {
namespace {

TEST(FullHouseTest, FirstOfTheLargestCrowdThatMayGoGoes) {
  EXPECT_EQ(WhoMakesRoom({{"a", true}, {"b", true}, {"a", false}, {"b", true}}), 1u);
  EXPECT_EQ(WhoMakesRoom({{"a", false}, {"a", false}, {"b", true}}), 2u);
  EXPECT_EQ(WhoMakesRoom({{"a", true}, {"b", true}}), 0u);
}

TEST(FullHouseTest, NobodyGoesWhoseRequestIsBeingDone) {
  EXPECT_FALSE(WhoMakesRoom({{"a", false}, {"b", false}}));
  EXPECT_FALSE(WhoMakesRoom({}));
}

}  // namespace
}  // namespace enamel::server::ops
