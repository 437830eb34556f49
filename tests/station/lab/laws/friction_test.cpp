#include <gtest/gtest.h>

#include <algorithm>

#include "common/fidelity/felt.h"
#include "station/lab/laws/model.h"
#include "station/lab/laws/motions.h"

// The device's friction taken out of the force, in hands that give.
namespace enamel::station::lab {
namespace {

const dvec3 kOblique = glm::normalize(dvec3(1, 2, 3));

// Strokes of the built-in exercises: B, N s/m, and mean speed.
struct Stroke {
  double b_n_s_per_m, speed_m_per_s;
};
constexpr Stroke kSlot{3560, 0.2e-3}, kWidening{890, 0.5e-3}, kDentin{530, 0.5e-3},
    kCaries{100, 1e-3};

DeviceModel Named(const std::string& name) {
  for (const scene::DeviceProfile& p : ShippedProfiles())
    if (p.name == name) return *ModelOf(p);
  ADD_FAILURE() << name;
  return {};
}

haptics::OwnFriction Guessed(const DeviceModel& m, double half_s) {
  return {dvec3(m.friction_n), false, half_s};
}
haptics::OwnFriction Measured(const DeviceModel& m) { return {dvec3(m.friction_n), true}; }

// In a grip, on a device whose true friction is `times` what the law is told.
double FeltError(const DeviceModel& m, const Stroke& stroke, double grip_n_per_m, double times,
                 const haptics::OwnFriction& told, const HandMotion& motion) {
  fidelity::FeltDevice device = FeltDeviceOf(m);
  device.friction_n *= times;
  fidelity::FeltTrial trial;
  trial.b_n_s_per_m = Sym3::Isotropic(stroke.b_n_s_per_m);
  trial.hand.stiffness_n_per_m = grip_n_per_m;
  trial.friction = told;
  trial.ideal = false;
  const auto f = Feel(device, trial, ScaledToSpeed(motion, stroke.speed_m_per_s).way_m);
  if (times >= 1) EXPECT_GE(f.energy_min_j, -1e-12) << m.name;
  return f.felt_error();
}

TEST(FrictionTest, AKnownFrictionLeftOutTakesAQuarterOffTheErrorOfStrokes) {
  const HandMotion motion = WanderingMotion(0.2e-3, 6, 1);
  for (const char* name : {"omega3", "bhhd3"}) {
    const DeviceModel m = Named(name);
    for (const Stroke& stroke : {kWidening, kDentin}) {
      const double off = FeltError(m, stroke, 1000, 1, {}, motion);
      EXPECT_LT(FeltError(m, stroke, 1000, 1, Measured(m), motion), 0.75 * off) << name;
    }
  }
}

// Motors that push along the motion, with the friction that a softer spring does not need: more than what can be left
// out of a force. Where the spring stays as stiff as in enamel, the cell takes nearly all of an Omega's friction.
TEST(FrictionTest, AMeasuredFrictionIsPushedAgainstInSoftTissue) {
  const DeviceModel m = Named("omega3");
  const HandMotion motion = WanderingMotion(0.5e-3, 6, 1);
  const auto felt = [&](double softest_s) {
    haptics::OwnFriction told = Measured(m);
    told.softest_s = softest_s;
    return FeltError(m, kCaries, 1000, 1, told, motion);
  };
  const double chosen = felt(haptics::kSoftest_s);
  EXPECT_LT(chosen, 0.36);
  EXPECT_GT(felt(haptics::kSoftest_s / 3), 0.42);
  EXPECT_GT(felt(3 * haptics::kSoftest_s), 0.38);
  EXPECT_GT(felt(1e-4), 0.6) << "as stiff as in enamel";
}

TEST(FrictionTest, HardTissueKeepsFrictionThatHidesASoftSpring) {
  const auto felt = [](const char* name, const Stroke& stroke, double half_s) {
    const DeviceModel m = Named(name);
    haptics::OwnFriction told = Measured(m);
    told.half_s = half_s;
    return FeltError(m, stroke, 1000, 1, told, WanderingMotion(0.2e-3, 6, 1));
  };
  EXPECT_LT(felt("bhhd3", kDentin, haptics::kMeasuredHalf_s), 0.2);
  EXPECT_GT(felt("bhhd3", kDentin, 0.1 * haptics::kMeasuredHalf_s), 0.22);
  EXPECT_LT(felt("phantom_desktop", kSlot, haptics::kMeasuredHalf_s), 0.22);
  EXPECT_GT(felt("phantom_desktop", kSlot, 10 * haptics::kMeasuredHalf_s), 0.235);
}

// The most points by which a stroke is felt worse than with nothing left out, where the true friction is half
// or twice the profile's.
double WorstOfGuess(double half_s) {
  const HandMotion strokes = StrokesMotion(0.43e-3, 1, 6, kOblique);
  const HandMotion wandering = WanderingMotion(0.2e-3, 6, 1);
  double worst = -1;
  for (const char* name : {"omega3", "phantom_desktop", "bhhd3"}) {
    const DeviceModel m = Named(name);
    for (const Stroke& stroke : {kSlot, kDentin, kCaries})
      for (double grip : {300.0, 2000.0})
        for (double times : {0.5, 2.0})
          for (const HandMotion* motion : {&strokes, &wandering})
            worst = std::max(worst, FeltError(m, stroke, grip, times, Guessed(m, half_s), *motion) -
                                        FeltError(m, stroke, grip, times, {}, *motion));
  }
  return 100 * worst;
}

TEST(FrictionTest, AGuessedFrictionMakesNoStrokeWorseByMoreThanAPoint) {
  EXPECT_LE(WorstOfGuess(haptics::kGuessedHalf_s), 1);
  // Four times as much would.
  EXPECT_GT(WorstOfGuess(4 * haptics::kGuessedHalf_s), 1);
}

TEST(FrictionTest, AGuessedFrictionStillTakesAThirdOffInCaries) {
  const DeviceModel m = Named("omega3");
  const HandMotion motion = WanderingMotion(0.2e-3, 6, 1);
  const double off = FeltError(m, kCaries, 1000, 1, {}, motion);
  const auto on = [&](double half_s) {
    return FeltError(m, kCaries, 1000, 1, Guessed(m, half_s), motion);
  };
  EXPECT_LT(on(haptics::kGuessedHalf_s), 0.75 * off);
  // A tenth of it would not.
  EXPECT_GT(on(0.1 * haptics::kGuessedHalf_s), 0.75 * off);
}

// A hand that pushes with c turns R around at rest again and again: nothing chatters.
TEST(FrictionTest, HandsThatPushSwingByNoMoreThanWithout) {
  const DeviceModel m = Named("omega3");
  const HandMotion rest{"rest", std::vector<dvec3>(6001, dvec3(0)), -1, false};
  for (double kg : {0.02, 0.1, 0.5}) {
    for (double push : {1.0, 1.1, 20.0}) {
      fidelity::FeltTrial trial;
      trial.hand.stiffness_n_per_m = 0;
      trial.hand.mass_kg = kg;
      trial.hand.damping_n_s_per_m = 0.3;
      trial.hand.push_n = kOblique * (push * m.friction_n);
      trial.from_s = 3;
      trial.ideal = trial.tool = false;
      const auto swing = [&](const haptics::OwnFriction& told) {
        trial.friction = told;
        const auto f = Feel(FeltDeviceOf(m), trial, rest.way_m);
        return f.most_n - f.least_n;
      };
      const double off = swing({}), on = swing(Measured(m));
      EXPECT_LE(on, off + m.kc_n_per_m * m.resolution_m) << kg << " kg, " << push;
      EXPECT_LE(on, 0.25) << kg << " kg, " << push;
    }
  }
}

}  // namespace
}  // namespace enamel::station::lab
