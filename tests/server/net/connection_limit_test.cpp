#include "server/net/connection_limit.h"

#include <gtest/gtest.h>

namespace enamel::server {
namespace {

TEST(ConnectionLimitTest, OldestOfTheBlockWithMostThatMayBeClosedIsClosed) {
  EXPECT_EQ(PickToClose({{"a", true}, {"b", true}, {"a", false}, {"b", true}}), 1u);
  EXPECT_EQ(PickToClose({{"a", false}, {"a", false}, {"b", true}}), 2u);
  EXPECT_EQ(PickToClose({{"a", true}, {"b", true}}), 0u);
}

TEST(ConnectionLimitTest, NoneIsClosedWhoseRequestIsBeingDone) {
  EXPECT_FALSE(PickToClose({{"a", false}, {"b", false}}));
  EXPECT_FALSE(PickToClose({}));
}

}  // namespace
}  // namespace enamel::server
