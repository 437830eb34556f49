#pragma once

#include "common/math/vec.h"

// The shared parts of the human-motion suite of `enamel-lab qualify` and the map of feel.h: how a
// hand strokes, what an encoder makes of it, and the track that force is measured against. SI
// units. Thread safety: pure functions, any thread. Real-time: safe.
namespace enamel::fidelity {

// Middle of the encoder cell of edge `delta_m` that holds x. Requires: delta_m > 0.
dvec3 CellMiddle(const dvec3& x_m, double delta_m);

// Share of the way at share u of the time of a minimum-jerk stroke, 10 u^3 - 15 u^4 + 6 u^5 (Flash
// and Hogan 1985), and its derivative, 30 u^2 (1 - u)^2: speed over mean speed, at most 1.875. At
// rest outside 0..1.
double MinimumJerk(double u);
double MinimumJerkRate(double u);

// The oracle: it knows the hand's speed exactly. Its force may fall at once, since letting the
// spring go only takes energy out, and rises by at most Kc |v| T in a tick (`rise_n`), never above
// the peak. From rest no passive law is faster: V' = F F'/Kc cannot exceed the hand's power F v, so
// F' <= Kc v. Later a law may be, on energy it kept (the tank of haptics/guard.h). The longest
// force along `wanted_n` that may follow `before_n`.
dvec3 OracleStep(const dvec3& before_n, const dvec3& wanted_n, double rise_n, double peak_n);

}  // namespace enamel::fidelity
