#include "common/scene/rate.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/haptics/criteria.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/profile_criteria.h"

namespace enamel::scene {
namespace {

DeviceProfile Device(const char* name) {
  for (const DeviceProfile& p : BuiltinProfiles()) {
    if (p.name == name) return p;
  }
  ADD_FAILURE() << name;
  return {};
}

TEST(RateTest, TheSmallestOfDampingFrictionAndStructureBinds) {
  DeviceProfile p = Device("omega3");  // b 6 N s/m, c 90 mN, delta 9 um, K 12 N/mm
  EXPECT_EQ(LargestCouplingAt(p, 500, 0).coupling_mn_per_mm, 6'000);
  EXPECT_EQ(LargestCouplingAt(p, 500, 0).limit, CouplingLimit::kDamping);
  EXPECT_EQ(LargestCouplingAt(p, 4000, 0).coupling_mn_per_mm, 10'936);  // cells of joints
  EXPECT_EQ(LargestCouplingAt(p, 4000, 0).limit, CouplingLimit::kFriction);
  p.cell.reset();
  EXPECT_EQ(LargestCouplingAt(p, 4000, 1).coupling_mn_per_mm, 12'000);
  EXPECT_EQ(LargestCouplingAt(p, 4000, 0).limit, CouplingLimit::kStructure);
  p.friction_mn.value = 45;
  EXPECT_EQ(LargestCouplingAt(p, 4000, 0).coupling_mn_per_mm, 10'000);
  EXPECT_EQ(LargestCouplingAt(p, 4000, 0).limit, CouplingLimit::kFriction);
}

// Compared with the closed forms in SI units, for every built-in device.
TEST(RateTest, IsWhatTheCriteriaAllowAtEveryRateAndMeetsThem) {
  for (DeviceProfile p : BuiltinProfiles()) {
    for (int64_t delay : {0, 1, 2}) {
      p.bus_delay_ticks.value = delay;
      for (int64_t rate : {1000, 2000, 4000, 8000}) {
        Result<DeviceProfile> at = AtRate(p, rate);
        ASSERT_TRUE(at.ok()) << p.name << ": " << at.status().message();
        const double d = static_cast<double>(at->bus_delay_ticks.value),
                     f = static_cast<double>(rate);
        EXPECT_GE(d / f, static_cast<double>(delay) / static_cast<double>(p.rate_hz.value) - 1e-12);
        const double b = static_cast<double>(p.damping_mn_s_per_m.value) * 1e-3;
        const double c = static_cast<double>(p.friction_mn.value) * 1e-3;
        // Half a cell; at joints half the diagonal of cell and count.
        const double delta = static_cast<double>(p.resolution_nm.value) * 1e-9;
        const double support =
            p.cell ? std::sqrt(0.75) * (delta + p.cell->count_nm * 1e-9) : delta / 2;
        const double allowed =
            std::min({haptics::CouplingStiffness(b, 1 / f, static_cast<int>(d)), c / support,
                      static_cast<double>(p.max_stiffness_mn_per_mm.value)});
        // Whole mN/mm, and a cell in whole nanometres, both to the safe side.
        const auto kc = static_cast<double>(at->coupling_mn_per_mm.value);
        EXPECT_LE(kc, allowed + 1e-6) << p.name << rate;
        EXPECT_GE(kc, allowed * (1 - 2e-9 / support) - 1.001) << p.name << rate;
        EXPECT_EQ(at->rate_hz.value, rate);
        EXPECT_TRUE(IsAcceptable(CheckProfile(*at))) << p.name << " " << rate;
      }
    }
  }
}

TEST(RateTest, ASpringOnTheBoardKeepsItsKcAtEveryRateOfTheLoop) {
  DeviceProfile p = Device("omega3");
  p.board_spring = BoardSpringSpec{8'000, 1, "test"};
  p.coupling_mn_per_mm.value = 9'000;
  for (int64_t rate : {500, 1000, 4000}) {
    Result<DeviceProfile> at = AtRate(p, rate);
    ASSERT_TRUE(at.ok()) << at.status().message();
    EXPECT_EQ(at->coupling_mn_per_mm.value, 9'000);
    EXPECT_TRUE(CheckCoupling(*at, rate, 2).ok());
    EXPECT_TRUE(IsAcceptable(CheckProfile(*at)));
  }
}

TEST(RateTest, ADelayIsKeptAsATimeAndARateThatNoCoreRunsIsRefused) {
  DeviceProfile p = Device("bhhd3");
  p.bus_delay_ticks.value = 1;
  EXPECT_EQ(AtRate(p, 4000)->bus_delay_ticks.value, 4);
  EXPECT_EQ(AtRate(p, 1500)->bus_delay_ticks.value, 2);
  EXPECT_EQ(AtRate(p, 1000)->bus_delay_ticks.value, 1);
  EXPECT_EQ(AtRate(p, 50).status().field(), "rate_hz");
  EXPECT_EQ(AtRate(p, 40'000).status().field(), "rate_hz");
  p.damping_mn_s_per_m.value = 0;
  EXPECT_EQ(AtRate(p, 4000).status().field(), "coupling_mn_per_mm");
}

}  // namespace
}  // namespace enamel::scene
