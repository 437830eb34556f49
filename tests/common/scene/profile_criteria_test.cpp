#include "common/scene/profile_criteria.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "common/scene/builtin/builtin.h"

namespace enamel::scene {
namespace {

const ProfileCriterion& Named(const std::vector<ProfileCriterion>& criteria,
                              const std::string& name) {
  for (const ProfileCriterion& criterion : criteria) {
    if (criterion.name == name) return criterion;
  }
  ADD_FAILURE() << "no criterion " << name;
  return criteria.front();
}

TEST(ProfileCriteriaTest, EveryBuiltinProfileIsAcceptable) {
  for (const DeviceProfile& profile : BuiltinProfiles()) {
    for (const ProfileCriterion& criterion : CheckProfile(profile)) {
      EXPECT_TRUE(criterion.met) << profile.name << " " << criterion.name;
    }
  }
}

// Worked by hand: b = 1.75 N s/m, T = 1 ms, c = 25 mN, delta = 10 um, Kc = 2500 N/m.
TEST(ProfileCriteriaTest, FiguresOfThePhantomDesktopAreThoseWorkedByHand) {
  auto profiles = BuiltinProfiles();
  auto found = std::ranges::find(profiles, "phantom_desktop", &DeviceProfile::name);
  ASSERT_NE(found, profiles.end());
  DeviceProfile phantom = *found;
  phantom.cell.reset();
  auto criteria = CheckProfile(phantom);
  EXPECT_NEAR(Named(criteria, "coupling_damping").limit, 3500, 1e-6);
  EXPECT_NEAR(Named(criteria, "coupling_damping").value, 2500, 1e-9);
  EXPECT_NEAR(Named(criteria, "coupling_friction").limit, 0.0125, 1e-12);
  phantom.bus_delay_ticks.value = 1;
  criteria = CheckProfile(phantom);
  EXPECT_NEAR(Named(criteria, "coupling_damping").limit, 3500.0 / 4, 1e-6);
  EXPECT_FALSE(Named(criteria, "coupling_damping").met);
  EXPECT_FALSE(IsAcceptable(criteria));
}

// b_rot = 0.5 mN m s/rad, T = 1 ms, K = 0.8 N m/rad, rho = 0.3 mrad, c_rot = 1 mN m, by hand.
TEST(ProfileCriteriaTest, TorqueHasItsOwnOnSixAxesOnly) {
  auto profiles = BuiltinProfiles();
  auto found = std::ranges::find(profiles, "sigma7", &DeviceProfile::name);
  ASSERT_NE(found, profiles.end());
  auto criteria = CheckProfile(*found);
  EXPECT_EQ(criteria.size(), 7u);
  EXPECT_NEAR(Named(criteria, "torque_damping").limit, 1, 1e-9);
  EXPECT_NEAR(Named(criteria, "torque_damping").value, 0.8, 1e-9);
  EXPECT_NEAR(Named(criteria, "torque_friction").limit, 240e-6, 1e-12);
  EXPECT_NEAR(Named(criteria, "torque_friction").value, 1e-3, 1e-12);
  EXPECT_NEAR(Named(criteria, "torque_peak").limit, 480e-6, 1e-12);
  found->bus_delay_ticks.value = 1;
  found->torque->friction_un_m.value = 239;
  criteria = CheckProfile(*found);
  EXPECT_FALSE(Named(criteria, "torque_damping").met);
  EXPECT_FALSE(Named(criteria, "torque_friction").met);
  EXPECT_EQ(CheckProfile(profiles.front()).size(), 4u);
  DeviceProfile damped = profiles.front();
  damped.electrical_damping_mn_s_per_m = {1000, "measured"};
  EXPECT_NEAR(Named(CheckProfile(damped), "coupling_damping").limit, 14'000, 1e-6);
}

// The plan's own integer conditions (plan.cpp), at the profile's rate.
TEST(ProfileCriteriaTest, AgreesWithIntegerArithmeticAlsoOnTheEdge) {
  std::mt19937 dice(7);
  auto pick = [&](int64_t lo, int64_t hi) {
    return std::uniform_int_distribution<int64_t>(lo, hi)(dice);
  };
  DeviceProfile profile = BuiltinProfiles().front();
  profile.cell.reset();
  for (int i = 0; i < 20'000; ++i) {
    profile.damping_mn_s_per_m.value = pick(1, 5000);
    profile.rate_hz.value = pick(5, 80) * 100;
    profile.bus_delay_ticks.value = pick(0, 3);
    profile.resolution_nm.value = pick(1, 50) * 1000;
    profile.friction_mn.value = pick(0, 100);
    int64_t d = (profile.bus_delay_ticks.value + 1) * (profile.bus_delay_ticks.value + 1);
    int64_t edge = 2 * profile.damping_mn_s_per_m.value * profile.rate_hz.value / (1000 * d);
    profile.coupling_mn_per_mm.value =
        std::max<int64_t>(1, i % 2 ? edge + pick(-1, 1) : pick(1, 5000));
    int64_t kc = profile.coupling_mn_per_mm.value;
    auto criteria = CheckProfile(profile);
    EXPECT_EQ(Named(criteria, "coupling_damping").met,
              kc * 1000 * d <= 2 * profile.damping_mn_s_per_m.value * profile.rate_hz.value);
    EXPECT_EQ(Named(criteria, "coupling_friction").met,
              2 * profile.friction_mn.value * 1'000'000 >= kc * profile.resolution_nm.value);
  }
}

}  // namespace
}  // namespace enamel::scene
