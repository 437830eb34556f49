#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/math/vec.h"

// How smooth a movement is, from its speed, and how much it trembles.
// Deterministic. Thread safety: functions, any thread; TremorMeter has one owner.
namespace enamel::scoring {

// Log dimensionless jerk: -ln(T^3 / v_max^2 * sum of v''^2 dt), with T = n dt and v'' the second
// difference over dt^2. Higher is smoother; a reach of least jerk has -ln 204.8 = -5.32. Nothing
// for fewer than three samples or a movement without jerk. Source: Balasubramanian,
// Melendez-Calderon, Burdet, IEEE Trans. Biomed. Eng. 59(8), 2012; the name: the same, J. NeuroEng.
// Rehab. 12:112, 2015. Which rate the samples have does not matter.
std::optional<double> LogDimensionlessJerk(std::span<const double> speed_m_s);

// Spectral arc length: minus the length of the speed's amplitude spectrum, scaled to 1 at its
// largest and to 1 along the frequencies, from the lowest to the highest frequency up to 10 Hz
// whose amplitude is at least 0.05. Zero-padded 16 times, to at most 2^17 samples. Higher is
// smoother. Nothing for a movement without speed. Source: Balasubramanian et al. 2015. Requires:
// rate_hz >= 20, so that 10 Hz are in the spectrum.
std::optional<double> SpectralArcLength(std::span<const double> speed_m_s, double rate_hz);

// Trembling from 8 to 12 Hz of a position: the means of 10 ms in windows of 100 of them (1 s at
// rates that are multiples of 100 Hz), Hann's weights, and the bins 8 to 12 of the discrete Fourier
// transform, corrected for the mean's own low pass. A sine of amplitude A along any direction on
// one of the bins 9 to 11 has A / sqrt 2 within a ten-thousandth; going straight at 2 mm/s adds 1
// um.
class TremorMeter {
 public:
  // Requires: rate_hz >= 100.
  explicit TremorMeter(uint32_t rate_hz);
  // Every tick in order. A window in which any tick is not `counts` is left out.
  void Add(const dvec3& position_m, bool counts);
  // Root mean square over the windows so far, of the three axes together; nothing without any.
  std::optional<double> Rms_m() const;

 private:
  static constexpr size_t kWindow = 100;
  void EndWindow();

  uint32_t mean_of_;  // ticks
  dvec3 sum_{0};
  uint32_t summed_ = 0;
  std::vector<dvec3> window_;
  double power_m2_ = 0;
  uint64_t windows_ = 0;
};

}  // namespace enamel::scoring
