#pragma once

#include <cstdint>
#include <span>

namespace enamel::station::sound {

// The sound of a handpiece: a tone at the bur's rotation, with two overtones, and a hiss while it
// cuts.
//
//   pitch = speed / 60          Hz, speed in 1/min
//
// Where the exercise's handpiece slows under load (core/handpiece.h), the speed is its own: the hand hears the spindle
// drop. Else DroopUnder says by what share a turbine would slow: about a quarter under the load at which students learn
// to stop. Pitch and loudness follow with first-order lags, and the tone's phase is never set back, so there
// is no click: between two samples the wave changes by at most MaxStep. Pure: the same calls give
// the same samples. Thread safety: none.
class HandpieceVoice {
 public:
  static constexpr double kDroop = 0.25;
  static double DroopUnder(double load) noexcept;

  static constexpr double kLag_s = 0.03;
  static constexpr double kTone = 0.12, kHiss = 0.05;  // amplitudes, 1 is full scale
  static constexpr double kHighest_hz = 7000;

  explicit HandpieceVoice(double rate_hz) : rate_hz_(rate_hz) {}

  // Applies from the next sample on. `speed_krpm` 0: the bur comes to rest. `load` 0..1, of the
  // force at which the bur should be lifted.
  void Set(double speed_krpm, double load);
  void Fill(std::span<float> samples);

  // The pitch's target, Hz.
  static double Pitch_hz(double speed_krpm);
  // Largest difference of two neighbouring samples at this rate.
  static double MaxStep(double rate_hz);

 private:
  float Next();

  const double rate_hz_;
  double wanted_hz_ = 0, wanted_tone_ = 0, wanted_hiss_ = 0;
  double hz_ = 0, tone_ = 0, hiss_ = 0;
  double phase_ = 0;  // turns
  double smooth_noise_ = 0;
  uint32_t noise_ = 0x9e3779b9;
};

}  // namespace enamel::station::sound
