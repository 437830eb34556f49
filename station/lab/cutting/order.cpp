#include "station/lab/cutting/order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace enamel::station::lab {
namespace {

constexpr size_t kSamples = 2000;

}  // namespace

double Rms(std::span<const double> errors) {
  double sum = 0;
  for (double e : errors) sum += e * e;
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

ObservedOrder OrderOf(std::span<const double> coarse, std::span<const double> fine, bool paired) {
  ObservedOrder out;
  out.order = std::log2(Rms(coarse) / Rms(fine));
  std::mt19937_64 draw(1);
  // Not std::uniform_int_distribution, which differs between libraries.
  auto sample = [](std::span<const double> from, std::mt19937_64& places) {
    double sum = 0;
    for (size_t i = 0; i < from.size(); ++i) {
      double e = from[places() % from.size()];
      sum += e * e;
    }
    return std::sqrt(sum / static_cast<double>(from.size()));
  };
  std::vector<double> orders;
  for (size_t i = 0; i < kSamples; ++i) {
    std::mt19937_64 same = draw;
    double a = sample(coarse, draw), b = sample(fine, paired ? same : draw);
    // Errors of 0 have no order, and may be drawn alone.
    if (a > 0 && b > 0) orders.push_back(std::log2(a / b));
  }
  if (orders.size() < kSamples) {
    out.low = out.high = std::numeric_limits<double>::quiet_NaN();
    return out;
  }
  std::sort(orders.begin(), orders.end());
  out.low = orders[kSamples * 25 / 1000];
  out.high = orders[kSamples * 975 / 1000];
  return out;
}

GridConvergence IndexOf(const std::array<double, 4>& v) {
  const double first = v[1] - v[0], second = v[2] - v[1], last = v[3] - v[2];
  GridConvergence out;
  out.order = out.index = std::numeric_limits<double>::quiet_NaN();
  // One sign, and smaller each time.
  if (!(second * last > 0 && first * second > 0 && std::fabs(last) < std::fabs(second))) return out;
  const double halving = second / last, before = first / second;
  out.asymptotic = before / halving > 0.75 && before / halving < 1.25;
  if (!out.asymptotic) return out;
  out.order = std::log2(halving);
  out.index = 1.25 * std::fabs(last) / (halving - 1);
  return out;
}

}  // namespace enamel::station::lab
