#include "station/sound/handpiece_voice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "station/sound/speaker.h"

namespace enamel::station::sound {
namespace {

constexpr double kRate_hz = 48'000;

// Strength of one frequency in a stretch of sound: Goertzel's sum, by its definition.
double Strength(const std::vector<float>& sound, double hz) {
  double re = 0, im = 0;
  for (size_t i = 0; i < sound.size(); ++i) {
    double angle = 2 * std::numbers::pi * hz * static_cast<double>(i) / kRate_hz;
    re += sound[i] * std::cos(angle);
    im += sound[i] * std::sin(angle);
  }
  return 2 * std::hypot(re, im) / static_cast<double>(sound.size());
}

// The frequency between 100 Hz and 7 kHz at which the sound is strongest.
double Loudest_hz(const std::vector<float>& sound) {
  double best = 0, best_strength = -1;
  for (double hz = 100; hz <= 7000; hz += 10) {
    double strength = Strength(sound, hz);
    if (strength > best_strength) best = hz, best_strength = strength;
  }
  return best;
}

std::vector<float> Steady(double speed_krpm, double load, size_t samples = 2400) {
  HandpieceVoice voice(kRate_hz);
  voice.Set(speed_krpm, load);
  std::vector<float> settle(24'000), sound(samples);
  voice.Fill(settle);
  voice.Fill(sound);
  return sound;
}

TEST(HandpieceVoiceTest, SoundsAtTheBursRotation) {
  EXPECT_NEAR(Loudest_hz(Steady(300, 0)), 5000, 10);
  EXPECT_NEAR(Loudest_hz(Steady(60, 0)), 1000, 10);
  EXPECT_NEAR(Loudest_hz(Steady(12, 0)), 200, 10);
}

TEST(HandpieceVoiceTest, AHandpieceThatNobodySimulatesLosesAQuarterOfItsSpeedAtMost) {
  EXPECT_EQ(HandpieceVoice::DroopUnder(0), 1);
  EXPECT_EQ(HandpieceVoice::DroopUnder(1), 0.75);
  EXPECT_EQ(HandpieceVoice::DroopUnder(7), 0.75);
  EXPECT_NEAR(Loudest_hz(Steady(300, 1)), 5000, 10) << "the pitch is the spindle's own";
}

TEST(HandpieceVoiceTest, HissesOnlyUnderLoad) {
  auto between = [](const std::vector<float>& sound) { return Strength(sound, 1730); };
  EXPECT_GT(between(Steady(300, 1, 9600)), 20 * between(Steady(300, 0, 9600)));
}

TEST(HandpieceVoiceTest, IsSilentAtRestAndFadesWhenThePedalIsLetGo) {
  HandpieceVoice voice(kRate_hz);
  std::vector<float> sound(4800);
  voice.Fill(sound);
  for (float s : sound) EXPECT_EQ(s, 0);
  voice.Set(300, 0.4);
  voice.Fill(sound);
  voice.Set(0, 0);
  std::vector<float> after(24'000);
  voice.Fill(after);
  double most = 0;
  for (size_t i = after.size() - 480; i < after.size(); ++i) {
    most = std::max(most, std::fabs(static_cast<double>(after[i])));
  }
  EXPECT_LT(most, 1e-6);
}

TEST(HandpieceVoiceTest, NeverClicksHoweverItIsDriven) {
  HandpieceVoice voice(kRate_hz);
  std::vector<float> block(37);
  double last = 0, most = 0, loudest = 0;
  for (int i = 0; i < 4000; ++i) {
    voice.Set(i % 7 == 0 ? 0 : i % 3 * 200, (i % 11) / 5.0);
    voice.Fill(block);
    for (float s : block) {
      most = std::max(most, std::fabs(s - last));
      loudest = std::max(loudest, std::fabs(static_cast<double>(s)));
      last = s;
    }
  }
  EXPECT_LE(most, HandpieceVoice::MaxStep(kRate_hz));
  EXPECT_GT(most, 0.01 * HandpieceVoice::MaxStep(kRate_hz));
  EXPECT_LT(loudest, 0.25);
}

TEST(HandpieceVoiceTest, WhatIsNotANumberChangesNothing) {
  HandpieceVoice a(kRate_hz), b(kRate_hz);
  a.Set(100, 0.2);
  b.Set(100, 0.2);
  b.Set(std::nan(""), 0);
  b.Set(100, std::numeric_limits<double>::infinity());
  std::vector<float> sa(1000), sb(1000);
  a.Fill(sa);
  b.Fill(sb);
  EXPECT_EQ(sa, sb);
}

TEST(SpeakerTest, IsThereAlsoWhereThereIsNoSoundCard) {
  Speaker speaker;
  speaker.Set(300, 0.5);
  speaker.Set(0, 0);
}

}  // namespace
}  // namespace enamel::station::sound
