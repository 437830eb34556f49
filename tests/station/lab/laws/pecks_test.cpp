#include "station/lab/laws/pecks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace enamel::station::lab {
namespace {

Unit Named(const std::string& name) {
  for (const scene::DeviceProfile& p : ShippedProfiles())
    if (p.name == name) return *UnitOf(p, true);
  ADD_FAILURE() << name;
  return {};
}

// Without masses a spring k and a damper B follow x' = (k/B) (place - x), and only inward.
TEST(PecksTest, AnIdealToolGoesAsDeepAsTheFormulaSays) {
  const Unit unit = Named("omega3");
  for (const Peck& p : AllPecks()) {
    double x_m = 0;
    constexpr double kStep_s = 1e-5;
    for (double t = 0; t < p.contact_s; t += kStep_s) {
      const double edge = std::min({t, p.contact_s - t, kPeckRise_s}) / kPeckRise_s;
      const double place_m = p.press_n / kPeckGrip_n_per_m * 0.5 * (1 - std::cos(M_PI * edge));
      x_m += std::max(0.0, kPeckGrip_n_per_m / p.b_n_s_per_m * (place_m - x_m) * kStep_s);
    }
    EXPECT_NEAR(RunPeck(unit.model, unit.told, p).tool_depth_m, x_m, 0.05 * x_m)
        << p.b_n_s_per_m << ", " << p.contact_s;
  }
}

// A device with a stiff spring, and nothing of its own, is the tool.
TEST(PecksTest, AStiffDeviceWithNothingOfItsOwnIsTheTool) {
  DeviceModel m = Named("omega3").model;
  m.kc_n_per_m = 1e6;
  m.mass_kg = 1e-3;
  m.damping_n_s_per_m = m.friction_n = 0;
  m.resolution_m = 1e-9;
  m.peak_force_n = 1e3;
  m.rate_hz = 20'000;
  const PeckFigures f = RunPeck(m, {}, {});
  EXPECT_NEAR(f.depth_m / f.tool_depth_m, 1, 0.05);
  EXPECT_LT(f.felt_error_rms_n, 0.1 * f.tool_rms_n);
}

// Outside programs found a fifth of the depth on an Inverse3, 0.03 to 0.13 on a Touch, in the hardest cut.
TEST(PecksTest, ASoftSpringTakesOffAFractionOfIt) {
  const Peck slot{0.7, 0.4, 3560};
  const auto share = [&](const char* name) {
    const Unit unit = Named(name);
    const PeckFigures f = RunPeck(unit.model, unit.told, slot);
    return f.depth_m / f.tool_depth_m;
  };
  EXPECT_LT(share("touch"), 0.15);
  EXPECT_LT(share("inverse3"), 0.3);
  EXPECT_GT(share("omega3"), share("phantom_desktop"));
  EXPECT_GT(share("phantom_desktop"), 2 * share("inverse3"));
}

}  // namespace
}  // namespace enamel::station::lab
