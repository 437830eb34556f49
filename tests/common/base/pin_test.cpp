#include "common/base/pin.h"

#include <gtest/gtest.h>

namespace enamel {
namespace {

TEST(PinTest, PinsThatAreGuessedFirstAreRefused) {
  for (const char* bad : {"", "12345", "1234567890123", "12345a", "000000", "123456", "987654",
                          "12 456", "\xd9\xa1\xd9\xa2\xd9\xa3"}) {
    EXPECT_EQ(CheckPin(bad).code(), Code::kInvalidInput) << bad;
  }
  for (const char* good : {"804217", "121212", "112233445566"}) {
    EXPECT_TRUE(CheckPin(good).ok()) << good;
  }
}

}  // namespace
}  // namespace enamel
