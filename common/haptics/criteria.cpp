#include "common/haptics/criteria.h"

#include "common/math/order.h"

namespace enamel::haptics {
namespace {

double NotNegative(double v) noexcept { return v > 0 ? v : 0; }
double Magnitude(double v) noexcept { return v < 0 ? -v : v; }

}  // namespace

double PaperDampingBound(double k, double speed, double delta, double f, double a) noexcept {
  return k * (speed + 2 * delta * f) / (4 * delta * f * f + a);
}

double PaperSpeedError(double delta, double f) noexcept { return 2 * delta * f; }
double PaperForceError(double b, double delta, double f) noexcept {
  return b * PaperSpeedError(delta, f);
}

double ColgateSchenkelStiffness(double b, double virtual_b, double tick) noexcept {
  return NotNegative(2 * (b - Magnitude(virtual_b)) / tick);
}

double ColgateSchenkelLowPassed(double b, double virtual_b, double tick, double tau) noexcept {
  return ColgateSchenkelStiffness(b, virtual_b * (tick / (2 * tau + tick)), tick);
}

double ColgateSchenkelWindowed(double b, double virtual_b, double tick, int ticks) noexcept {
  return ColgateSchenkelStiffness(b, virtual_b / ticks, tick);
}

double AbbottOkamuraStiffness(double b, double tick, double friction, double delta) noexcept {
  return LowerOf(2 * b / tick, 2 * friction / delta);
}

double GilStiffness(double b, double virtual_b, double tick, int delay) noexcept {
  return NotNegative((b + virtual_b) / (tick * (0.5 + delay)));
}

double CouplingStiffness(double b, double tick, int delay) noexcept {
  const double held = delay + 1.0;  // ticks from a reading to the end of its force
  return 2 * b / (held * held * tick);
}
double CouplingFriction(double kc, double delta) noexcept { return kc * delta / 2; }

double LateTickLeak(double kc, double b, double hold, double moved) noexcept {
  return NotNegative(kc / 2 - b / hold) * moved * moved;
}

Dimensionless DimensionlessGroups(double k, double b, double c, double tick,
                                  double delta) noexcept {
  return {b / (k * tick), c / (k * delta)};
}

double MaxwellTimeConstant(double b, double kc) noexcept { return b / kc; }

}  // namespace enamel::haptics
