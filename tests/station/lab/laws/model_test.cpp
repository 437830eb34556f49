#include "station/lab/laws/model.h"

#include <gtest/gtest.h>

#include "common/scene/find_profile.h"

namespace enamel::station::lab {
namespace {

TEST(DeviceModelTest, EveryProfileIsPassiveAndSaysWhereItsNumbersAreFrom) {
  ASSERT_GE(ShippedProfiles().size(), 14u);
  for (const auto& profile : ShippedProfiles()) {
    auto model = ModelOf(profile);
    ASSERT_TRUE(model.ok()) << profile.name << ": " << model.status().message();
    EXPECT_LE(model->kc_n_per_m, model->PassiveKc(model->rate_hz) * (1 + 1e-9));
    for (const auto& [what, source] : model->provenance)
      EXPECT_FALSE(source.empty()) << profile.name << " " << what;
  }
}

TEST(DeviceModelTest, RefusesWhatCannotBeRunNamingTheField) {
  auto Refused = [](auto change) {
    auto profile = ShippedProfiles()[1];
    change(profile);
    auto model = ModelOf(profile);
    return model.ok() ? std::string() : model.status().field();
  };
  using P = scene::DeviceProfile;
  EXPECT_EQ(Refused([](P& p) { p.max_stiffness_mn_per_mm.value = 0; }), "max_stiffness_mn_per_mm");
  EXPECT_EQ(Refused([](P& p) { p.resolution_nm.value = -1; }), "resolution_nm");
  EXPECT_EQ(Refused([](P& p) { p.rate_hz.value = 0; }), "rate_hz");
  EXPECT_EQ(Refused([](P& p) { p.damping_mn_s_per_m.value = -5; }), "damping_mn_s_per_m");
  EXPECT_EQ(Refused([](P& p) { p.peak_force_mn.value = 0; }), "peak_force_mn");
}

// b = 1.75 N s/m: 2b/T = 3500 N/m at 1 kHz, and a quarter of it with one tick of delay.
TEST(DeviceModelTest, RefusesTooStiffACouplingWithTheNumberThatWouldDo) {
  auto profile = ShippedProfiles()[1];
  profile.friction_mn.value = 100;
  profile.coupling_mn_per_mm.value = 3600;
  auto model = ModelOf(profile);
  ASSERT_FALSE(model.ok());
  EXPECT_NE(model.status().message().find("3500"), std::string::npos) << model.status().message();
  profile.bus_delay_ticks.value = 1;
  model = ModelOf(profile);
  ASSERT_FALSE(model.ok());
  EXPECT_NE(model.status().message().find("875"), std::string::npos) << model.status().message();
}

TEST(DeviceModelTest, SaysWhatItCannotRenderAndForHowLongThePeakLasts) {
  auto touch = ModelOf(*scene::FindProfile("touch"));
  ASSERT_TRUE(touch.ok());
  EXPECT_FALSE(CannotRender(*touch, 6500, 0.43e-3).empty());
  auto omega = ModelOf(ShippedProfiles()[0]);
  EXPECT_TRUE(CannotRender(*omega, 6500, 0.43e-3).empty());
  EXPECT_EQ(CannotRender(*omega, 6500, 2e-3).size(), 1u);
}

// Table 3 of the paper prints the limiter's force in one experiment, not the motors' continuous
// force.
TEST(DeviceModelTest, NoContinuousForceIsTheLimitersForceOfThePapersTable3) {
  for (const auto& profile : ShippedProfiles()) {
    EXPECT_EQ(profile.continuous_force_mn.source.find("paper"), std::string::npos) << profile.name;
    EXPECT_LE(profile.continuous_force_mn.value, profile.peak_force_mn.value) << profile.name;
  }
}

// 2.795 N against 1.75 N continuous: (F/Fc)^2 (1 - exp(-t/tau)) = 1 at t = 0.4975 tau.
TEST(DeviceModelTest, SaysInSecondsHowLongThePeakLastsWhereTheTimeConstantIsKnown) {
  auto profile = ShippedProfiles()[1];
  profile.thermal_time_constant_ms = {60'000, "measured: warmed until its cut-out"};
  auto phantom = ModelOf(profile);
  ASSERT_TRUE(phantom.ok());
  auto limits = CannotRender(*phantom, 6500, 0.43e-3);
  ASSERT_EQ(limits.size(), 1u);
  EXPECT_NE(limits[0].find("29.9 s"), std::string::npos) << limits[0];
}

}  // namespace
}  // namespace enamel::station::lab
