#pragma once

namespace enamel {

struct SinCos {
  double sin = 0, cos = 1;
};

// Sine and cosine of `turns` full turns, 0 <= turns <= 1, from + - * alone, so the last bit is the
// same on every machine (libm's is not). Error below 1e-15. For tables that a core builds at its
// start.
SinCos SinCosOfTurns(double turns) noexcept;

// Angle of a slope, radians, from + - * / sqrt alone, for the same reason. Error below 1e-15.
double ArcTan(double slope) noexcept;

}  // namespace enamel
