#pragma once

#include <cmath>
#include <cstdint>

#include "common/math/vec.h"

namespace enamel::testing_support {

// Random numbers that are the same for a seed on every machine, unlike the standard library's
// distributions.
class Dice {
 public:
  explicit Dice(uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15ull + 1) {}
  double Uniform() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  double Signed() { return 2 * Uniform() - 1; }
  int Below(int n) { return static_cast<int>(n * Uniform()); }
  dvec3 Vector() { return dvec3(Signed(), Signed(), Signed()); }
  dvec3 Direction() {
    for (;;) {
      dvec3 v = Vector();
      double n = std::sqrt(Dot(v, v));
      if (n > 0.1 && n < 1) return v / n;
    }
  }
  // Three orthonormal columns, turned at random.
  dmat3 Frame() {
    dvec3 a = Direction(), b = Direction();
    b -= a * Dot(a, b);
    b /= std::sqrt(Dot(b, b));
    return dmat3(a, b, glm::cross(a, b));
  }

 private:
  uint64_t state_;
};

}  // namespace enamel::testing_support
