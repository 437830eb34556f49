#include "common/fidelity/random.h"

#include <cmath>

namespace enamel::fidelity {

uint64_t Random::Next() {
  // SplitMix64 (Steele, Lea and Flood 2014): 64 bits of state, identical on every machine, which no
  // library's distribution promises.
  uint64_t z = (state_ += kStep);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

double Random::Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }

double Random::LogBetween(double lo, double hi) {
  return lo * std::exp(Uniform() * std::log(hi / lo));
}

// Marsaglia's polar method.
double Random::Normal() {
  for (;;) {
    double a = Signed(), b = Signed(), r = a * a + b * b;
    if (r > 0 && r < 1) return a * std::sqrt(-2 * std::log(r) / r);
  }
}

dvec3 Random::Direction() {
  for (;;) {
    dvec3 d(Normal(), Normal(), Normal());
    double n = glm::length(d);
    if (n > 1e-6) return d / n;
  }
}

}  // namespace enamel::fidelity
