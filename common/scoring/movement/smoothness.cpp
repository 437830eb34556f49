#include "common/scoring/movement/smoothness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "common/math/log.h"
#include "common/math/trig.h"

namespace enamel::scoring {
namespace {

constexpr double kCutoff_hz = 10, kMinAmplitude = 0.05;
constexpr size_t kPadding = 16, kMaxPadded = size_t{1} << 17;
constexpr size_t kFirstBin = 8, kLastBin = 12;

// The discrete Fourier transform in place, by halves (Cooley and Tukey 1965). Its size is a power
// of two.
void Transform(std::vector<double>& re, std::vector<double>& im) {
  const size_t n = re.size();
  for (size_t i = 1, j = 0; i < n; ++i) {
    size_t bit = n >> 1;
    for (; (j & bit) != 0; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(re[i], re[j]), std::swap(im[i], im[j]);
  }
  std::vector<SinCos> turn(n / 2);
  for (size_t i = 0; i < turn.size(); ++i) {
    turn[i] = SinCosOfTurns(static_cast<double>(i) / static_cast<double>(n));
  }
  for (size_t half = 1; half < n; half *= 2) {
    for (size_t from = 0; from < n; from += 2 * half) {
      for (size_t k = 0; k < half; ++k) {
        const SinCos& w = turn[k * (n / (2 * half))];
        const size_t a = from + k, b = a + half;
        const double x = re[b] * w.cos + im[b] * w.sin, y = im[b] * w.cos - re[b] * w.sin;
        re[b] = re[a] - x, im[b] = im[a] - y;
        re[a] += x, im[a] += y;
      }
    }
  }
}

// Sine and cosine of i hundredths of a turn.
const std::array<SinCos, 100>& Hundredths() {
  static const auto table = [] {
    std::array<SinCos, 100> out;
    for (size_t i = 0; i < out.size(); ++i) out[i] = SinCosOfTurns(static_cast<double>(i) / 100);
    return out;
  }();
  return table;
}

}  // namespace

std::optional<double> LogDimensionlessJerk(std::span<const double> speed) {
  if (speed.size() < 3) return std::nullopt;
  double peak = 0, squares = 0;
  for (double v : speed) peak = std::max(peak, std::fabs(v));
  for (size_t i = 2; i < speed.size(); ++i) {
    const double second = speed[i] - 2 * speed[i - 1] + speed[i - 2];
    squares += second * second;
  }
  if (!(peak > 0) || !(squares > 0)) return std::nullopt;
  // T^3 times the square of 1 / dt^2 times dt is n^3: nothing but the profile's shape is left.
  const auto n = static_cast<double>(speed.size());
  return -NaturalLog(n * n * n * (squares / (peak * peak)));
}

std::optional<double> SpectralArcLength(std::span<const double> speed, double rate_hz) {
  if (speed.empty()) return std::nullopt;
  size_t padded = 1;
  while (padded < speed.size()) padded *= 2;
  padded = std::max(padded, std::min(padded * kPadding, kMaxPadded));
  std::vector<double> re(padded), im(padded);
  std::copy(speed.begin(), speed.end(), re.begin());
  Transform(re, im);
  // Up to the cutoff, without the upper half, which mirrors the lower.
  const double step_hz = rate_hz / static_cast<double>(padded);
  std::vector<double> amplitude;
  double most = 0;
  for (size_t k = 0; k <= padded / 2; ++k) {
    amplitude.push_back(std::sqrt(re[k] * re[k] + im[k] * im[k]));
    most = std::max(most, amplitude.back());
    if (static_cast<double>(k + 1) * step_hz > kCutoff_hz) break;
  }
  if (!(most > 0)) return std::nullopt;
  size_t first = amplitude.size(), last = 0;
  for (size_t k = 0; k < amplitude.size(); ++k) {
    amplitude[k] /= most;
    if (amplitude[k] < kMinAmplitude) continue;
    first = std::min(first, k);
    last = k;
  }
  double length = 0;
  for (size_t k = first + 1; k <= last; ++k) {
    const double along = 1 / static_cast<double>(last - first);
    const double up = amplitude[k] - amplitude[k - 1];
    length += std::sqrt(along * along + up * up);
  }
  return -length;
}

TremorMeter::TremorMeter(uint32_t rate_hz) : mean_of_(std::max(1u, rate_hz / 100)) {
  window_.reserve(kWindow);
}

void TremorMeter::Add(const dvec3& position_m, bool counts) {
  if (!counts) {
    window_.clear();
    sum_ = dvec3(0);
    summed_ = 0;
    return;
  }
  sum_ += position_m;
  if (++summed_ < mean_of_) return;
  window_.push_back(sum_ / static_cast<double>(mean_of_));
  sum_ = dvec3(0);
  summed_ = 0;
  if (window_.size() == kWindow) EndWindow();
}

void TremorMeter::EndWindow() {
  const auto& turn = Hundredths();
  constexpr double kN = kWindow;
  // Hann: w = (1 - cos(2 pi i / N)) / 2, the sum of whose squares is 3/8 N.
  constexpr double kScale = 2 / (kN * 0.375 * kN);
  for (size_t bin = kFirstBin; bin <= kLastBin; ++bin) {
    dvec3 re(0), im(0);
    for (size_t i = 0; i < kWindow; ++i) {
      // From the first position, so that no digits go to where in space it is.
      const dvec3 d = (window_[i] - window_[0]) * (0.5 * (1 - turn[i].cos));
      const SinCos& w = turn[bin * i % kWindow];
      re += d * w.cos;
      im += d * w.sin;
    }
    // A mean of k ticks passes sin(pi f k) / (k sin(pi f)) of a sine of f turns a tick.
    const double turns = static_cast<double>(bin) / (kN * mean_of_);
    const double passes =
        SinCosOfTurns(0.5 * turns * mean_of_).sin / (mean_of_ * SinCosOfTurns(0.5 * turns).sin);
    power_m2_ += kScale * (Dot(re, re) + Dot(im, im)) / (passes * passes);
  }
  ++windows_;
  window_.clear();
}

std::optional<double> TremorMeter::Rms_m() const {
  if (windows_ == 0) return std::nullopt;
  return std::sqrt(power_m2_ / static_cast<double>(windows_));
}

}  // namespace enamel::scoring
