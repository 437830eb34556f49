#include "station/session/hand_turn.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/support/temp_folder.h"

namespace enamel::station {
namespace {

class Arm final : public MotorDevice {
 public:
  explicit Arm(std::string unit) : unit_(std::move(unit)) {}
  std::string Name() const override { return "arm"; }
  std::string Unit() const override { return unit_; }
  Hand hand() const override { return MakeHand(HandKind::kHaptic, Name(), "test"); }
  DeviceSample ReadSample() noexcept override { return {}; }
  void SendForceAndTorque(const dvec3&, const dvec3&) noexcept override {}

 private:
  std::string unit_;
};

TEST(HandTurnTest, IsKeptForEachUnitAndForANameWithoutOne) {
  test::TempFolder folder;
  const Arm one("hid:1209:0001:A"), other("hid:1209:0001:B"), nameless("");
  EXPECT_EQ(HandTurnOf(folder.path(), one, 180), 180);
  ASSERT_TRUE(KeepHandTurn(folder.path(), one, 270).ok());
  ASSERT_TRUE(KeepHandTurn(folder.path(), nameless, 90).ok());
  EXPECT_EQ(HandTurnOf(folder.path(), one, 180), 270);
  EXPECT_EQ(HandTurnOf(folder.path(), nameless, 180), 90);
  EXPECT_EQ(HandTurnOf(folder.path(), other, 180), 180);
  ASSERT_TRUE(KeepHandTurn(folder.path(), one, 0).ok());
  EXPECT_EQ(HandTurnOf(folder.path(), one, 180), 0);
  EXPECT_EQ(HandTurnOf(folder.path(), nameless, 180), 90);
}

TEST(HandTurnTest, AFileOfAnotherKindCountsAsNone) {
  test::TempFolder folder;
  const Arm arm("");
  for (const char* text : {"", "[]", "{\"arm\":", R"({"arm":"90"})", R"({"arm":45})",
                           R"({"arm":-90})", R"({"arm":360})", R"({"arm":90.0})"}) {
    std::ofstream(folder.path() / "hand_turns.json") << text;
    EXPECT_EQ(HandTurnOf(folder.path(), arm, 180), 180) << text;
  }
  std::ofstream(folder.path() / "hand_turns.json") << R"({"arm":90,"other":45})";
  EXPECT_EQ(HandTurnOf(folder.path(), arm, 180), 90) << "one that is wrong costs no other";
}

}  // namespace
}  // namespace enamel::station
