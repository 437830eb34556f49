#include "station/sound/warning_tone.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace enamel::station::sound {
namespace {

constexpr double kWholeTurn = 2 * std::numbers::pi;
// Within 15 dB of each other, as the standard asks; their sum is 1.
constexpr double kPulsePartials[] = {0.34, 0.24, 0.18, 0.14, 0.10};

}  // namespace

void WarningTone::Set(Hazard hazard, double nearness) {
  if (!std::isfinite(nearness)) return;
  const bool near = nearness > 0;
  // The first pulse begins with the warning, not somewhere within its silence.
  if (near && pulses_hz_ == 0) pulse_ = 0;
  pulses_hz_ = near ? kSlowest_hz + (kFastest_hz - kSlowest_hz) * std::min(nearness, 1.0) : 0;
  if (near) wanted_hz_ = hazard == Hazard::kPulp ? kPulp_hz : kNeighbour_hz;
}

double WarningTone::Next() {
  pulse_ += pulses_hz_ / rate_hz_;
  pulse_ -= std::floor(pulse_);
  const bool sounds = pulses_hz_ > 0 && pulse_ < 0.5;
  const double share = 1 / (kLag_s * rate_hz_);
  loudness_ += ((sounds ? kLoudness : 0) - loudness_) * share;
  hz_ += (wanted_hz_ - hz_) * share;
  phase_ += hz_ / rate_hz_;
  phase_ -= std::floor(phase_);
  double wave = 0, partial = 1;
  for (double amplitude : kPulsePartials)
    wave += amplitude * std::sin(kWholeTurn * partial++ * phase_);
  return loudness_ * wave;
}

void WarningTone::AddTo(std::span<float> samples) {
  for (float& sample : samples) sample += static_cast<float>(Next());
}

double WarningTone::MaxStep(double rate_hz) {
  double slope = 0, partial = 1;
  for (double amplitude : kPulsePartials) slope += amplitude * partial++;
  // The wave's slope, and its loudness' change.
  return kLoudness * (slope * kWholeTurn * kPulp_hz + 1 / kLag_s) / rate_hz;
}

}  // namespace enamel::station::sound
