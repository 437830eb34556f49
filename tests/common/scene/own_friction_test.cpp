#include "common/scene/own_friction.h"

#include <gtest/gtest.h>

#include "common/scene/builtin/builtin.h"
#include "common/scene/cell.h"
#include "common/scene/delay.h"
#include "common/scene/plan.h"

namespace enamel::scene {
namespace {

DeviceProfile Phantom() { return BuiltinProfiles()[1]; }

TEST(OwnFrictionTest, CountsAtTheLowerEndOfAnIntervalThatIsNarrowEnough) {
  Calibration unit;
  EXPECT_FALSE(FrictionOf(unit).has_value());
  unit.friction_mn = Measured{100, 15, 40};
  EXPECT_EQ(FrictionOf(unit), 84);
  unit.friction_mn->uncertainty = 16;
  EXPECT_FALSE(FrictionOf(unit).has_value());
  unit.friction_mn = Measured{0, 0, 40};
  EXPECT_FALSE(FrictionOf(unit).has_value());
}

// c/S: 25 mN carry 2.75 N/mm on the Phantom's cell, which has 2.5.
TEST(OwnFrictionTest, LowersKcToWhatItCarriesAndNeverRaisesIt) {
  const int64_t support_nm = CellSupportNm(Phantom());
  EXPECT_EQ(WithFriction(Phantom(), 60).coupling_mn_per_mm.value, 2500);
  const DeviceProfile slippery = WithFriction(Phantom(), 12);
  EXPECT_EQ(slippery.coupling_mn_per_mm.value, 12 * 1'000'000 / support_nm);
  EXPECT_EQ(slippery.friction_mn.value, 12);
  EXPECT_TRUE(slippery.friction_of_unit);
  DeviceProfile board = Phantom();
  board.board_spring = BoardSpringSpec{8000, 1, "test"};
  EXPECT_FALSE(WithFriction(board, 12).friction_of_unit);
  EXPECT_TRUE(WithFriction(board, 60).friction_of_unit);
}

TEST(OwnFrictionTest, ParametersOfAMeasuredUnitAreTheExercisesWithItsKc) {
  auto built = BuildBuiltinScene("block", 200'000);
  ASSERT_TRUE(built.ok());
  const Exercise exercise = ClassOneExercise(built->scene, {});
  for (int64_t c : {12, 25, 60}) {
    const auto unit = WithDelay(WithFriction(Phantom(), c), exercise.rate_hz, 1);
    ASSERT_TRUE(unit.ok());
    auto params = CompilePlan(built->scene, exercise, *unit);
    ASSERT_TRUE(params.ok()) << params.status().message();
    EXPECT_TRUE(CheckParams(built->scene, exercise, Phantom(), *params).ok()) << c;
    // Another friction on one axis, or a Kc that this friction does not carry.
    core::CoreParams other = *params;
    other.friction_mn[1] += 1;
    EXPECT_FALSE(CheckParams(built->scene, exercise, Phantom(), other).ok()) << c;
    other = *params;
    other.kc_mn_per_mm += 1;
    EXPECT_FALSE(CheckParams(built->scene, exercise, Phantom(), other).ok()) << c;
  }
}

}  // namespace
}  // namespace enamel::scene
