#include "common/fidelity/cut_strokes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/scene/find_profile.h"

namespace enamel::fidelity {
namespace {

constexpr double kB_n_s_per_m = 800, kSpeed_m_per_s = 0.5e-3;

core::CoreParams ParamsOf(const scene::DeviceProfile& profile, uint32_t rate_hz = 1000) {
  core::CoreParams p;
  p.rate_hz = rate_hz;
  p.kc_mn_per_mm = static_cast<int32_t>(profile.coupling_mn_per_mm.value);
  p.peak_force_mn = static_cast<int32_t>(profile.peak_force_mn.value);
  p.resolution_nm = {1000, 1000, 1000};
  return p;
}

scene::DeviceProfile Profile(const char* name) { return *scene::FindProfile(name); }

// A bur that cuts along x for `cut_s` against F = B v and then rests for `rest_s`, over and over.
struct Recorded {
  CutStrokes strokes;
  double rate_hz, x_m = 0;

  explicit Recorded(const core::CoreParams& p) : strokes(p), rate_hz(p.rate_hz) {}
  uint8_t flags = core::kBurOn;
  void Cut(double seconds, double speed = kSpeed_m_per_s, uint32_t gap_ticks = 0) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds * rate_hz)); ++i) {
      x_m += speed / rate_hz;
      core::TickInput input;
      core::TickWitness witness;
      input.flags = flags;
      input.gap_ticks = i == 0 ? gap_ticks : 0;
      // The tip leads the bur by the spring.
      input.counts[0] = static_cast<int32_t>(std::lround((x_m + 50e-6) * 1e6));
      witness.anchor_100nm[0] = static_cast<int32_t>(std::lround(x_m * 1e7));
      witness.force_computed_mn[0] = -static_cast<int32_t>(std::lround(kB_n_s_per_m * speed * 1e3));
      strokes.Add(input, witness);
    }
  }
};

TEST(CutStrokesTest, AStrokeHasTheDampingSpeedAndTimeThatItWasMadeWith) {
  for (const uint32_t rate_hz : {1000u, 4000u}) {
    Recorded r(ParamsOf(Profile("omega3"), rate_hz));
    r.Cut(1);
    r.Cut(0.5, 0);
    r.Cut(1);
    const auto found = r.strokes.Spread(2);
    ASSERT_EQ(found.size(), 2u);
    for (const CutStroke& s : found) {
      EXPECT_NEAR(s.b_n_s_per_m, kB_n_s_per_m, 0.01 * kB_n_s_per_m) << rate_hz;
      EXPECT_NEAR(s.speed_m_per_s, kSpeed_m_per_s, 0.01 * kSpeed_m_per_s);
      EXPECT_NEAR(s.seconds, 1, 0.02);
      EXPECT_NEAR(static_cast<double>(s.way_m.size()), 1000, 20);
      EXPECT_EQ(glm::length(s.way_m.front()), 0);
      EXPECT_NEAR(s.way_m.back().x, kSpeed_m_per_s, 0.02 * kSpeed_m_per_s);
    }
  }
}

TEST(CutStrokesTest, RestsShortTouchesAndGapsAreNoStrokes) {
  Recorded r(ParamsOf(Profile("omega3")));
  EXPECT_TRUE(r.strokes.Spread(8).empty());
  r.Cut(0.2);
  r.Cut(1, 0);
  r.Cut(0.25);
  r.Cut(0.25, kSpeed_m_per_s, 30);  // over the gap nobody knows the way
  EXPECT_TRUE(r.strokes.Spread(8).empty());
}

// Two minutes of short strokes: what is kept is bounded, and stands for all of it.
TEST(CutStrokesTest, ALongRecordingTakesNoMoreMemory) {
  Recorded r(ParamsOf(Profile("omega3")));
  for (int i = 0; i < 200; ++i) {
    r.Cut(0.4);
    r.Cut(0.2, 0);
  }
  double seconds = 0;
  const auto found = r.strokes.Spread(1000);
  for (const CutStroke& s : found) seconds += s.seconds;
  EXPECT_NEAR(seconds, 200 * 0.4, 0.02 * 80);
  EXPECT_LE(r.strokes.kept(), CutStrokes::kMaxStrokes);
}

// Without friction and mass in a stiff device hardly anything is off; the friction is, by c over the force.
TEST(CutStrokesTest, TheErrorIsTheDevicesFriction) {
  scene::DeviceProfile profile = Profile("omega3");
  profile.mass_g.value = 1;
  profile.damping_mn_s_per_m.value = 100;
  profile.resolution_nm.value = 100;
  const core::CoreParams params = ParamsOf(profile);
  const auto error = [&](int64_t friction_mn, int32_t told_mn) {
    profile.friction_mn.value = friction_mn;
    core::CoreParams p = params;
    p.friction_mn = {told_mn, told_mn, told_mn};
    p.friction_measured = told_mn > 0;
    Recorded r(p);
    for (int i = 0; i < 4; ++i) {
      r.Cut(2);
      r.Cut(0.2, 0);
    }
    return FeltErrorOf(profile, p, r.strokes).value();
  };
  const double without = error(1, 0), with = error(100, 0), left_out = error(100, 100);
  const double force_n = kB_n_s_per_m * kSpeed_m_per_s;
  EXPECT_LT(without, 0.1);
  EXPECT_NEAR(with, 0.1 / force_n, 0.2 * 0.1 / force_n);
  EXPECT_LT(left_out, 0.5 * with);
}

// A unit rubs as it was measured, whatever the profile of its kind says.
TEST(CutStrokesTest, AMeasuredFrictionIsTheUnits) {
  const auto profile = Profile("omega7");
  core::CoreParams p = ParamsOf(profile);
  p.friction_mn = {80, 80, 80};
  p.friction_measured = true;
  EXPECT_NEAR(FeltDeviceOf(profile, p).friction_n, 0.08, 1e-9);
  p.friction_measured = false;
  EXPECT_NEAR(FeltDeviceOf(profile, p).friction_n, 0.012, 1e-9);
}

TEST(CutStrokesTest, ABurThatStandsFeelsAndDoesNotCut) {
  Recorded r(ParamsOf(Profile("omega3")));
  r.flags = 0;
  r.Cut(2);
  EXPECT_TRUE(r.strokes.Spread(8).empty());
}

TEST(CutStrokesTest, ARateBetweenTwoThousandsHasNoError) {
  const auto omega = Profile("omega3");
  for (const uint32_t rate_hz : {500u, 1500u}) {
    Recorded r(ParamsOf(omega, rate_hz));
    r.Cut(2);
    EXPECT_FALSE(FeltErrorOf(omega, ParamsOf(omega, rate_hz), r.strokes)) << rate_hz;
  }
}

TEST(CutStrokesTest, WithoutMotorsOrACutThereIsNoError) {
  const auto omega = Profile("omega3"), mouse = Profile("pointer");
  Recorded nothing(ParamsOf(omega)), cut(ParamsOf(mouse));
  nothing.Cut(1, 0);
  cut.Cut(2);
  EXPECT_FALSE(FeltErrorOf(omega, ParamsOf(omega), nothing.strokes));
  EXPECT_FALSE(FeltErrorOf(mouse, ParamsOf(mouse), cut.strokes));
}

}  // namespace
}  // namespace enamel::fidelity
