#include <gtest/gtest.h>

#include <algorithm>

#include "common/fidelity/felt.h"
#include "common/scene/own_friction.h"
#include "station/lab/laws/model.h"
#include "station/lab/laws/motions.h"

// The device's friction left out of what the law asks of the motors, in hands that give.
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
  return {dvec3(m.friction_n), m.kc_n_per_m * half_s};
}

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
      EXPECT_LT(FeltError(m, stroke, 1000, 1, {dvec3(m.friction_n)}, motion), 0.75 * off) << name;
    }
  }
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
  EXPECT_LE(WorstOfGuess(scene::kUnmeasuredHalf_us * 1e-6), 1);
  // Four times as much would.
  EXPECT_GT(WorstOfGuess(4e-6 * scene::kUnmeasuredHalf_us), 1);
}

TEST(FrictionTest, AGuessedFrictionStillTakesAThirdOffInCaries) {
  const DeviceModel m = Named("omega3");
  const HandMotion motion = WanderingMotion(0.2e-3, 6, 1);
  const double off = FeltError(m, kCaries, 1000, 1, {}, motion);
  const auto on = [&](double half_s) {
    return FeltError(m, kCaries, 1000, 1, Guessed(m, half_s), motion);
  };
  EXPECT_LT(on(scene::kUnmeasuredHalf_us * 1e-6), 0.75 * off);
  // A tenth of it would not.
  EXPECT_GT(on(0.1e-6 * scene::kUnmeasuredHalf_us), 0.75 * off);
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
      const double off = swing({}), on = swing({dvec3(m.friction_n)});
      EXPECT_LE(on, off + m.kc_n_per_m * m.resolution_m) << kg << " kg, " << push;
      EXPECT_LE(on, 0.25) << kg << " kg, " << push;
    }
  }
}

}  // namespace
}  // namespace enamel::station::lab
