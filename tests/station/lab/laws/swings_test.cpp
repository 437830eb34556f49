#include "station/lab/laws/swings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace enamel::station::lab {
namespace {

const ProfileError& ErrorOf(const char* name) {
  const std::vector<ProfileError>& all = ProfileErrors();
  return *std::find_if(all.begin(), all.end(),
                       [&](const ProfileError& e) { return std::strcmp(e.name, name) == 0; });
}

DeviceModel Model(size_t i) { return *ModelOf(ShippedProfiles()[i]); }

std::vector<dvec3> Sine(double hz, double peak_to_peak_n, double from_s, double seconds) {
  std::vector<dvec3> out;
  for (int i = 0; i < 1000 * seconds; ++i) {
    const double t = i * 1e-3;
    out.push_back(dvec3(
        3 - t, 0, t < from_s ? 0 : 0.5 * peak_to_peak_n * std::sin(2 * M_PI * hz * (t - from_s))));
  }
  return out;
}

TEST(SwingsTest, ASwingBeginsWhereItPassesOneNewtonPeakToPeak) {
  const auto begins = SwingBegins(Sine(20, 1.3, 1, 3), 1e-3);
  ASSERT_TRUE(begins);
  // Half a period after it starts, and a ramp of 1 N/s is none.
  EXPECT_NEAR(*begins, 1.03, 0.025);
  EXPECT_NEAR(SwingLeft(Sine(20, 1.3, 1, 3), 1e-3), 1.3, 0.1);
  EXPECT_FALSE(SwingBegins(Sine(20, 0.7, 1, 3), 1e-3));
  EXPECT_FALSE(SwingBegins(Sine(20, 1.3, 2.7, 3), 1e-3)) << "it lasts for .3 s";
}

// Fixed seeds, a part of the suite.
TEST(SwingsTest, NoHandOnADeviceThatIsWhatItsProfileSaysTripsTheWatch) {
  for (size_t device : {0, 1, 5}) {
    const DeviceModel m = Model(device);
    for (int i = 0; i < 24; ++i) {
      Random random(400 + static_cast<uint64_t>(i));
      const SwingHand hand = kSwingHands[i % 4];
      const SwingTrial trial = DrawSwingTrial(hand, m, i % 3 == 0, random);
      const auto force = RunSwingTrial(m, trial, ProfileErrors().front(), false);
      EXPECT_FALSE(SwingSeen(force, {})) << m.name << " " << NameOf(hand) << " " << i;
    }
  }
}

TEST(SwingsTest, LightHandsThatLandOnAWrongProfileSwingAreSeenAndHeld) {
  int swings = 0, seen = 0, soon = 0, held = 0;
  for (size_t device : {0, 1, 2}) {
    const DeviceModel m = Model(device);
    for (int i = 0; i < 16; ++i) {
      Random random(900 + static_cast<uint64_t>(i));
      const SwingTrial trial = DrawSwingTrial(SwingHand::kLand, m, true, random);
      const ProfileError& error = ErrorOf(i % 2 == 0 ? "b/4 c/2, one tick" : "two ticks");
      const auto force = RunSwingTrial(m, trial, error, false);
      const auto begins = SwingBegins(force, m.tick_s());
      if (!begins) continue;
      ++swings;
      const auto at_s = SwingSeen(force, {});
      seen += at_s.has_value();
      soon += at_s && *at_s - *begins <= 0.2;
      held += SwingLeft(RunSwingTrial(m, trial, error, true), m.tick_s()) <= 1.5;
    }
  }
  EXPECT_GE(swings, 12);
  EXPECT_GE(seen, swings - 1);
  EXPECT_GE(soon, swings * 8 / 10);
  EXPECT_GE(held, swings * 9 / 10);
}

}  // namespace
}  // namespace enamel::station::lab
