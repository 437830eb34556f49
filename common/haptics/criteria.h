#pragma once

#include "common/math/vec.h"

// Closed-form stability criteria of the literature, in SI units, one function each, so that a profile
// page and a qualification can show them side by side with what the simulation finds.
//
// Symbols: K virtual or coupling stiffness (N/m), B virtual damping (N s/m), b device's viscous
// damping (N s/m), c Coulomb friction per axis (N), delta encoder resolution (m), T tick (s), f = 1/T,
// d whole ticks of delay between reading and force. All functions: pure, any thread, real-time safe.
namespace enamel::haptics {

// Liu et al. 2008 eq. 16: sufficient bound on B for eq. 1 without a limiter,
// B <= K (V + 2 delta f) / (4 delta f^2 + a), V speed (m/s), a = f |V_i - V_{i-1}| (m/s^2).
// For V << 2 delta f it is K T / 2: delta cancels, and it is the dual of Colgate-Schenkel.
double PaperDampingBound(double k_n_per_m, double speed_m_per_s, double resolution_m,
                         double rate_hz, double acceleration_m_per_s2) noexcept;

// Errors of eq. 1 from one quantisation cell, per axis: speed 2 delta f, force 2 B delta f (eq. 3-9).
double PaperSpeedError(double resolution_m, double rate_hz) noexcept;
double PaperForceError(double b_n_s_per_m, double resolution_m, double rate_hz) noexcept;

// Colgate and Schenkel 1997, passivity of a sampled wall K, B with backward-difference velocity:
// b > K T / 2 + |B|. The largest K for a given B (zero when B alone is too much).
double ColgateSchenkelStiffness(double b_n_s_per_m, double virtual_b_n_s_per_m,
                                double tick_s) noexcept;
// The same wall when the velocity passes a first-order low-pass of time constant tau before B: the
// discrete filter's gain at Nyquist, T / (2 tau + T), is what multiplies |B| (bilinear form).
double ColgateSchenkelLowPassed(double b_n_s_per_m, double virtual_b_n_s_per_m, double tick_s,
                                double time_constant_s) noexcept;
// And when it is a mean over n ticks: B acts with 1/n of its high-frequency gain.
double ColgateSchenkelWindowed(double b_n_s_per_m, double virtual_b_n_s_per_m, double tick_s,
                               int ticks) noexcept;

// Abbott and Okamura 2005, with quantisation and Coulomb friction: K <= min(2 b / T, 2 c / delta).
double AbbottOkamuraStiffness(double b_n_s_per_m, double tick_s, double friction_n,
                              double resolution_m) noexcept;

// Gil, Avello, Rubio, Florez 2004 (linear stability, rigid mass) with d ticks of delay, no human:
// K < (b + B) / (T / 2 + d T), valid for K T^2 / m << 1.
double GilStiffness(double b_n_s_per_m, double virtual_b_n_s_per_m, double tick_s,
                    int delay_ticks) noexcept;

// Passive limit of the coupling of coupling.h with d ticks of delay: Kc <= 2 b / ((d + 1)^2 T), with
// friction as below; for d >= 1 only where the guard debits twice, s^2 w^2 in place of s^2 w^2 / 2.
// Derivation: README.md beside this, "With delay". Kc <= 2 b / (T (2 d + 1)), the linear limit of
// Gil et al., is not enough for d >= 1: a tip that dithers across a cell's edge is pumped.
double CouplingStiffness(double b_n_s_per_m, double tick_s, int delay_ticks) noexcept;
// Coulomb friction the coupling's theorem asks for, per axis: Kc delta / 2.
double CouplingFriction(double kc_n_per_m, double resolution_m) noexcept;

// Energy a tick that was held too long may leak: max(0, Kc/2 - b/T_hold) |dx|^2, J.
double LateTickLeak(double kc_n_per_m, double b_n_s_per_m, double hold_s, double moved_m) noexcept;

// Dimensionless groups of Diolaiti et al. 2006: beta = b / (K T), sigma = c / (K delta). The wall is
// passive for beta >= 1/2 and sigma >= 1/2.
struct Dimensionless {
  double beta = 0, sigma = 0;
};
Dimensionless DimensionlessGroups(double k_n_per_m, double b_n_s_per_m, double friction_n,
                                  double tick_s, double resolution_m) noexcept;

// Time constant of the Maxwell coupling, B / Kc (s), and its closed-form rise to 90 % under a
// velocity-controlled hand: ln(10) B / Kc. The slope limit alone allows 0.9 B / Kc.
double MaxwellTimeConstant(double b_n_s_per_m, double kc_n_per_m) noexcept;

}  // namespace enamel::haptics
