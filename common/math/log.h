#pragma once

namespace enamel {

// Natural logarithm from + - * / alone, so the last bit is the same on every machine (libm's is
// not). Relative error below 1e-15. Requires: x > 0, normal and finite.
double NaturalLog(double x) noexcept;

}  // namespace enamel
