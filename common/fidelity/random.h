#pragma once

#include <cstdint>

#include "common/math/vec.h"

namespace enamel::fidelity {

// Seeded numbers for the suites: splitmix64, the same on every machine. Uniform in [0, 1), signed
// in [-1, 1), integers below n, and a standard normal (12 uniforms less 6 would lack tails:
// Marsaglia).
class Random {
 public:
  // What each number adds to the seed: Random(seed + n * kStep) gives what Random(seed) gives after n numbers.
  static constexpr uint64_t kStep = 0x9e3779b97f4a7c15;

  explicit Random(uint64_t seed) : state_(seed) {}
  uint64_t Next();
  double Uniform();
  double Signed() { return 2 * Uniform() - 1; }
  double Between(double lo, double hi) { return lo + (hi - lo) * Uniform(); }
  double LogBetween(double lo, double hi);
  int Below(int n) { return static_cast<int>(Next() % static_cast<uint64_t>(n)); }
  double Normal();
  dvec3 Direction();

 private:
  uint64_t state_;
};

}  // namespace enamel::fidelity
