#include "station/sound/warning_tone.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace enamel::station::sound {
namespace {

constexpr double kToneRate_hz = 48'000;

std::vector<float> Sound(Hazard hazard, double nearness, double seconds) {
  WarningTone tone(kToneRate_hz);
  tone.Set(hazard, nearness);
  std::vector<float> sound(static_cast<size_t>(seconds * kToneRate_hz));
  tone.AddTo(sound);
  return sound;
}

// Strength of one frequency in the first pulse.
double InPulse(const std::vector<float>& sound, double hz) {
  double re = 0, im = 0;
  for (size_t i = 0; i < 4800; ++i) {
    const double angle = 2 * std::numbers::pi * hz * static_cast<double>(i) / kToneRate_hz;
    re += sound[i] * std::cos(angle);
    im += sound[i] * std::sin(angle);
  }
  return 2 * std::hypot(re, im) / 4800;
}

// Pulses: stretches of sound after at least 20 ms of near silence.
int Pulses(const std::vector<float>& sound) {
  int pulses = 0, quiet = 960;
  for (float s : sound) {
    if (std::fabs(s) < 0.01f) {
      ++quiet;
      continue;
    }
    if (quiet >= 960) ++pulses;
    quiet = 0;
  }
  return pulses;
}

TEST(WarningToneTest, PulsesFasterAsTheHazardComesNearer) {
  EXPECT_EQ(Pulses(Sound(Hazard::kPulp, 1e-6, 2)), 4);
  EXPECT_EQ(Pulses(Sound(Hazard::kPulp, 0.5, 2)), 12);
  EXPECT_EQ(Pulses(Sound(Hazard::kPulp, 1, 2)), 20);
  EXPECT_EQ(Pulses(Sound(Hazard::kPulp, 7, 2)), 20) << "never so fast that pulses fuse";
}

TEST(WarningToneTest, EachHazardHasItsOwnPitchWithPartials) {
  const auto pulp = Sound(Hazard::kPulp, 0.1, 0.2), neighbour = Sound(Hazard::kNeighbour, 0.1, 0.2);
  EXPECT_GT(InPulse(pulp, WarningTone::kPulp_hz), 10 * InPulse(pulp, WarningTone::kNeighbour_hz));
  EXPECT_GT(InPulse(neighbour, WarningTone::kNeighbour_hz),
            10 * InPulse(neighbour, WarningTone::kPulp_hz));
  // IEC 60601-1-8: four more partials within 15 dB.
  for (int partial = 2; partial <= 5; ++partial) {
    EXPECT_GT(InPulse(pulp, partial * WarningTone::kPulp_hz),
              std::pow(10, -15 / 20.0) * InPulse(pulp, WarningTone::kPulp_hz))
        << partial;
  }
}

TEST(WarningToneTest, IsSilentWhereNothingIsNear) {
  for (float s : Sound(Hazard::kPulp, 0, 0.5)) EXPECT_EQ(s, 0);
  WarningTone tone(kToneRate_hz);
  std::vector<float> sound(4800);
  tone.Set(Hazard::kPulp, 1);
  tone.AddTo(sound);
  tone.Set(Hazard::kPulp, 0);
  sound.assign(4800, 0);
  tone.AddTo(sound);
  for (size_t i = 2400; i < sound.size(); ++i) EXPECT_LT(std::fabs(sound[i]), 1e-4);
}

TEST(WarningToneTest, NeverClicksHoweverItIsDriven) {
  WarningTone tone(kToneRate_hz);
  double last = 0, most = 0, loudest = 0;
  for (int i = 0; i < 4000; ++i) {
    tone.Set(i % 5 == 0 ? Hazard::kNeighbour : Hazard::kPulp, i % 7 == 0 ? 0 : (i % 11) / 8.0);
    std::vector<float> block(37);
    tone.AddTo(block);
    for (float s : block) {
      most = std::max(most, std::fabs(s - last));
      loudest = std::max(loudest, std::fabs(static_cast<double>(s)));
      last = s;
    }
  }
  EXPECT_LE(most, WarningTone::MaxStep(kToneRate_hz));
  EXPECT_GT(most, 0.05 * WarningTone::MaxStep(kToneRate_hz));
  EXPECT_LE(loudest, WarningTone::kLoudness);
}

TEST(WarningToneTest, WhatIsNotANumberChangesNothing) {
  WarningTone a(kToneRate_hz), b(kToneRate_hz);
  a.Set(Hazard::kPulp, 0.2);
  b.Set(Hazard::kPulp, 0.2);
  b.Set(Hazard::kNeighbour, std::numeric_limits<double>::quiet_NaN());
  std::vector<float> sa(1000), sb(1000);
  a.AddTo(sa);
  b.AddTo(sb);
  EXPECT_EQ(sa, sb);
}

}  // namespace
}  // namespace enamel::station::sound
