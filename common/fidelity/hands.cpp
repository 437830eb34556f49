#include "common/fidelity/hands.h"

#include <algorithm>
#include <cmath>

namespace enamel::fidelity {
namespace {

// How far a line motion has come, signed.
double Travel(const LineMotion& m, double t_s) {
  double t = std::min(t_s, m.stop_s);
  // Mirrored in time: back along the same way at the same speed.
  if (m.reverse_s > 0 && t > m.reverse_s) t = 2 * m.reverse_s - t;
  return m.speed_m_per_s * t;
}

}  // namespace

dvec3 LineMotion::PositionAt(double t_s) const {
  double s = Travel(*this, t_s);
  if (tremor_m > 0) s += tremor_m * std::sin(2 * M_PI * tremor_hz * t_s);
  return start_m + direction * s;
}

dvec3 LineMotion::SpeedAt(double t_s) const {
  double v = t_s >= stop_s ? 0 : reverse_s > 0 && t_s > reverse_s ? -speed_m_per_s : speed_m_per_s;
  if (tremor_m > 0) v += 2 * M_PI * tremor_hz * tremor_m * std::cos(2 * M_PI * tremor_hz * t_s);
  return direction * v;
}

Grip VelocityHand::At(double t_s) {
  Grip g;
  g.prescribed = true;
  g.equilibrium_m = motion_.PositionAt(t_s);
  return g;
}

Grip ForceHand::At(double t_s) {
  Grip g;
  if (t_s < stop_s_) g.force_n = force_;
  g.damping_n_s_per_m = damping_;
  return g;
}

Grip ImpedanceHand::At(double t_s) {
  Grip g;
  g.equilibrium_m = motion_.PositionAt(t_s);
  g.equilibrium_speed_m_per_s = motion_.SpeedAt(t_s);
  g.stiffness_n_per_m = stiffness_;
  g.damping_n_s_per_m = damping_;
  return g;
}

Grip ScriptedHand::At(double t_s) {
  Grip g;
  g.prescribed = true;
  auto last = static_cast<double>(positions_.size() - 1);
  double at = std::clamp(t_s / tick_s_, 0.0, last);
  auto i = static_cast<size_t>(at);
  double share = at - static_cast<double>(i);
  g.equilibrium_m = i + 1 < positions_.size()
                        ? positions_[i] * (1 - share) + positions_[i + 1] * share
                        : positions_[i];
  return g;
}

}  // namespace enamel::fidelity
