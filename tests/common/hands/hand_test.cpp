#include "common/hands/hand.h"

#include <gtest/gtest.h>

#include "common/base/utf8.h"

namespace enamel {
namespace {

const Hand kBoard = MakeHand(HandKind::kHaptic, "omega.3", "hid", "hid:1209:0001:A7");
const Hand kMouse = MakeHand(HandKind::kPointer, "mouse and keyboard", "mouse");
const Hand kDentist = MakeHand(HandKind::kProgram, "simulated device", "operator dentist");
const Hand kUnnamed;

TEST(HandTest, NamesAreStableAndReadBack) {
  for (int kind = 0; kind <= 3; ++kind) {
    auto value = static_cast<HandKind>(kind);
    EXPECT_EQ(HandKindFromName(HandKindName(value)), value);
  }
  for (int each = 1; each <= 4; ++each) {
    auto value = static_cast<HandsAllowed>(each);
    EXPECT_EQ(HandsAllowedFromName(HandsAllowedName(value)), value);
  }
  EXPECT_STREQ(HandKindName(HandKind::kProgram), "program");
  EXPECT_STREQ(HandsAllowedName(HandsAllowed::kListed), "listed");
  EXPECT_FALSE(HandKindFromName("robot"));
  EXPECT_FALSE(HandsAllowedFromName(""));
}

TEST(HandTest, EachTermAdmitsWhatTheStricterOnesDo) {
  struct Case {
    HandsAllowed allowed;
    const Hand& hand;
    bool listed, may;
  };
  using enum HandsAllowed;
  const Case cases[] = {
      {kListed, kBoard, true, true},      {kListed, kBoard, false, false},
      {kListed, kMouse, true, false},     {kListed, kDentist, true, false},
      {kListed, kUnnamed, true, false},   {kHaptic, kBoard, false, true},
      {kHaptic, kMouse, false, false},    {kHaptic, kDentist, false, false},
      {kHaptic, kUnnamed, false, false},  {kPointer, kBoard, false, true},
      {kPointer, kMouse, false, true},    {kPointer, kDentist, false, false},
      {kPointer, kUnnamed, false, false}, {kAny, kBoard, false, true},
      {kAny, kMouse, false, true},        {kAny, kDentist, false, true},
      {kAny, kUnnamed, false, true},
  };
  for (const Case& c : cases) {
    Status status = MayHold(c.allowed, c.hand, c.listed);
    EXPECT_EQ(status.ok(), c.may) << HandsAllowedName(c.allowed) << ", " << HandText(c.hand);
    if (c.may) continue;
    EXPECT_EQ(status.code(), Code::kForbidden);
    EXPECT_EQ(status.field(), "hand");
  }
}

TEST(HandTest, RefusalSaysWhatWasExpectedWhatWasFoundAndWhatToDo) {
  EXPECT_EQ(MayHold(HandsAllowed::kListed, kDentist, false).message(),
            "graded work here is done with a haptic device on the school's list, found a simulated "
            "hand (operator dentist); use such a device, or ask an instructor to allow this one in "
            "the assignment");
  EXPECT_EQ(MayHold(HandsAllowed::kListed, kBoard, false).message(),
            "graded work here is done with a haptic device on the school's list, found omega.3 "
            "(hid:1209:0001:A7); an admin puts it on the list as \"hid:1209:0001:A7\"");
  EXPECT_NE(MayHold(HandsAllowed::kHaptic, kUnnamed, false).message().find("name the device"),
            std::string::npos);
}

TEST(HandTest, DeviceThatCannotTellItsUnitIsListedByItsModel) {
  EXPECT_EQ(ListedAs(kBoard), "hid:1209:0001:A7");
  EXPECT_EQ(ListedAs(MakeHand(HandKind::kHaptic, "PHANTOM Desktop", "openhaptics")),
            "PHANTOM Desktop");
}

TEST(HandTest, TextsOfADeviceAreMadePrintableAndCutBetweenCharacters) {
  std::string name = "a\x1b[31m\xff";
  for (int i = 0; i < 100; ++i) name += "\xc3\xa9";
  const Hand hand = MakeHand(HandKind::kHaptic, name, "hid");
  EXPECT_LE(hand.device.size(), kMaxHandTextBytes);
  EXPECT_GE(hand.device.size(), kMaxHandTextBytes - 1);
  EXPECT_TRUE(IsUtf8(hand.device));
  EXPECT_EQ(hand.device.find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace enamel
