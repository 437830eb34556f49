#pragma once

// The lower and the higher of two numbers, spelled out: with a NaN the second is taken, on every
// compiler. Thread safety: pure functions, any thread. Real-time: safe.
namespace enamel {

inline double LowerOf(double a, double b) noexcept { return a < b ? a : b; }
inline double HigherOf(double a, double b) noexcept { return a > b ? a : b; }
inline double Clamped(double v, double lo, double hi) noexcept {
  return v < lo ? lo : v > hi ? hi : v;
}

}  // namespace enamel
