#include "station/sound/handpiece_voice.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace enamel::station::sound {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kPartials[] = {1.0, 0.35, 0.12};
constexpr double kNoiseShare = 0.25;  // of new noise per sample: takes the sharpest hiss away

}  // namespace

double HandpieceVoice::DroopUnder(double load) noexcept {
  return 1 - kDroop * std::clamp(load, 0.0, 1.0);
}

double HandpieceVoice::Pitch_hz(double speed_krpm) {
  return std::min(std::max(speed_krpm, 0.0) * 1000 / 60, kHighest_hz);
}

double HandpieceVoice::MaxStep(double rate_hz) {
  double tone = 0;
  for (int i = 0; i < 3; ++i) tone += kPartials[i] * (i + 1);
  // The tone's slope, its loudness' change, and the filtered noise's largest step.
  return kTone * tone * kTurn * kHighest_hz / rate_hz + 2 * kTone / (kLag_s * rate_hz) +
         2 * kHiss * kNoiseShare;
}

void HandpieceVoice::Set(double speed_krpm, double load) {
  if (!std::isfinite(speed_krpm) || !std::isfinite(load)) return;
  bool turning = speed_krpm > 0;
  // A bur that comes to rest keeps its pitch while it fades.
  if (turning) wanted_hz_ = Pitch_hz(speed_krpm);
  wanted_tone_ = turning ? kTone : 0;
  wanted_hiss_ = turning ? kHiss * std::clamp(load, 0.0, 1.0) : 0;
}

float HandpieceVoice::Next() {
  double share = 1 / (kLag_s * rate_hz_);
  hz_ += (wanted_hz_ - hz_) * share;
  tone_ += (wanted_tone_ - tone_) * share;
  hiss_ += (wanted_hiss_ - hiss_) * share;
  phase_ += hz_ / rate_hz_;
  phase_ -= std::floor(phase_);
  double wave = 0;
  for (int i = 0; i < 3; ++i) wave += kPartials[i] * std::sin(kTurn * (i + 1) * phase_);
  noise_ = noise_ * 1664525u + 1013904223u;  // Numerical Recipes' ranqd1
  double white = static_cast<double>(noise_) / 2147483648.0 - 1;
  smooth_noise_ += (white - smooth_noise_) * kNoiseShare;
  return static_cast<float>(tone_ * wave + hiss_ * smooth_noise_);
}

void HandpieceVoice::Fill(std::span<float> samples) {
  for (float& sample : samples) sample = Next();
}

}  // namespace enamel::station::sound
