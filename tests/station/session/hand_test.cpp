#include <gtest/gtest.h>

#include "station/devices/button_source.h"
#include "station/devices/pointer_device.h"
#include "station/devices/simulated_device.h"
#include "station/session/prepared_attempt.h"
#include "tests/support/block_plan.h"

namespace enamel::station {
namespace {

std::unique_ptr<Device> Simulated() {
  PlantParams plant;
  plant.mass_kg = 0.1;
  plant.resolution_m = 1e-5;
  return std::make_unique<SimulatedDevice>(plant, std::make_unique<NobodyHolding>());
}

class NoPedal final : public ButtonSource {
 public:
  std::string Name() const override { return "pedal"; }
  uint8_t buttons() const noexcept override { return 0; }
};

TEST(HandTest, DeviceSaysWhatHoldsIt) {
  EXPECT_EQ(Simulated()->hand().kind, HandKind::kProgram);
  EXPECT_EQ(Simulated()->hand().driver, "operator nobody");
  EXPECT_EQ(PointerDevice(1e-6, 1e-3).hand().kind, HandKind::kPointer);
  PedalledDevice pedalled(Simulated(), std::make_unique<NoPedal>());
  EXPECT_EQ(pedalled.hand().kind, HandKind::kProgram) << "a pedal makes no person of a program";
}

TEST(HandTest, HeaderTellsOfTheDeviceAndATicketTakenBeforeMayNotAdmitIt) {
  PreparedAttempt prepared;
  PointerDevice mouse(1e-6, 1e-3);
  ASSERT_TRUE(UseHandOf(prepared, mouse).ok());
  EXPECT_EQ(prepared.header.hand, mouse.hand());
  prepared.hands = HandsAllowed::kHaptic;
  EXPECT_EQ(UseHandOf(prepared, mouse).field(), "hand");
  prepared.hands = HandsAllowed::kPointer;
  EXPECT_TRUE(UseHandOf(prepared, mouse).ok());
}

TEST(HandTest, ResumedAttemptGoesOnWithTheKindOfHandItWasBegunWith) {
  test::BlockPlan block = test::MakeBlockPlan();
  PreparedAttempt prepared;
  prepared.core = std::make_unique<core::Core>(block.params, block.volume);
  PointerDevice mouse(1e-6, 1e-3);
  prepared.header.hand = MakeHand(HandKind::kHaptic, "omega.3", "hid");
  Status other = UseHandOf(prepared, mouse);
  EXPECT_EQ(other.code(), Code::kConflict);
  EXPECT_NE(other.message().find("omega.3"), std::string::npos) << other.message();
  prepared.header.hand = mouse.hand();
  EXPECT_TRUE(UseHandOf(prepared, mouse).ok());
}

}  // namespace
}  // namespace enamel::station
