#include "station/desk/stop_sign.h"

#include <gtest/gtest.h>

namespace enamel::station::desk {
namespace {

TEST(StopSignTest, EachFaultHasASignAndAFaultComesFirst) {
  EXPECT_EQ(StopOf(Fault::kUnplugged, false, false), Stop::kUnplugged);
  EXPECT_EQ(StopOf(Fault::kStalled, true, true), Stop::kUnplugged);
  EXPECT_EQ(StopOf(Fault::kSwitchedOff, false, false), Stop::kPower);
  for (Fault late : {Fault::kLateOnce, Fault::kLateOften}) {
    EXPECT_EQ(StopOf(late, false, true), Stop::kBusy);
  }
  EXPECT_EQ(StopOf(Fault::kNone, true, true), Stop::kDisk);
  EXPECT_EQ(StopOf(Fault::kNone, true, false), Stop::kHolder);
  EXPECT_EQ(StopOf(Fault::kNone, false, false), Stop::kNone);
}

}  // namespace
}  // namespace enamel::station::desk
