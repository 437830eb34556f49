#pragma once

#include <span>

namespace enamel::station::sound {

// What a warning is about. Each has a pitch of its own.
enum class Hazard { kPulp, kNeighbour };

// Pulses that warn of something near, faster as it comes nearer:
//
//   pulses a second = kSlowest_hz + (kFastest_hz - kSlowest_hz) * nearness    nearness 0..1, above 0
//
// Each pulse sounds for half of its time. Both ends are far below the 20 a second at which pulses
// fuse into a tone. The pulse follows IEC 60601-1-8 (alarms of medical equipment): a fundamental of
// 150 to 1000 Hz and four more partials up to 4 kHz, so that it is heard beside a turbine's single
// high tone and on small loudspeakers, which have no bass. The pitches are a fifth apart. Loudness
// follows with a first-order lag and the phase is never set back, so there is no click: between two
// samples the wave changes by at most MaxStep. Pure: the same calls give the same samples. Thread
// safety: none.
class WarningTone {
 public:
  static constexpr double kSlowest_hz = 2, kFastest_hz = 10;
  static constexpr double kPulp_hz = 784, kNeighbour_hz = 523;  // G5, C5
  static constexpr double kLoudness = 0.2;                      // amplitude, 1 is full scale
  static constexpr double kLag_s = 0.004;

  explicit WarningTone(double rate_hz) : rate_hz_(rate_hz) {}

  // Applies from the next sample on. `nearness` 0: silence; 1: touching.
  void Set(Hazard hazard, double nearness);
  // Adds to what is there.
  void AddTo(std::span<float> samples);

  // Largest difference of two neighbouring samples at this rate.
  static double MaxStep(double rate_hz);

 private:
  double Next();

  const double rate_hz_;
  double pulses_hz_ = 0;  // 0: silence
  double wanted_hz_ = kPulp_hz, hz_ = kPulp_hz;
  double pulse_ = 0, phase_ = 0;  // turns
  double loudness_ = 0;
};

}  // namespace enamel::station::sound
