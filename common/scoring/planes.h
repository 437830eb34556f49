#pragma once

#include <vector>

// Planes through heights over a wall, a floor or any other patch of a surface. Thread safety:
// functions, any thread. Deterministic.
namespace enamel::scoring {

// A height d over a patch at (s, t) in it, metres, and the area it stands for, m^2.
struct Height {
  double d = 0, area = 0, s = 0, t = 0;
};

// d = d0 + b (s - s0) + c (t - t0).
struct Plane {
  double s0 = 0, t0 = 0, d0 = 0, b = 0, c = 0;
  double At(const Height& h) const { return d0 + b * (h.s - s0) + c * (h.t - t0); }
};

// Least squares, by area. A patch without extent one way has no slope that way.
Plane FitPlane(const std::vector<Height>& heights);

// A plane through most of the heights, which are left: the foot of another wall that leans in, a
// gouge or a lip is not the lean of this one. First drops heights far from the median, which a
// ditch at one side moves less than a plane; then heights more than four median residuals off, and
// more than `least_m`. A wall that leans as a whole stays, as its farthest height is twice the
// median away. A wave stays whole, since its crest is 1.4 of them.
Plane FitPlaneToMost(std::vector<Height>& heights, double least_m);

// Root mean square of the heights about the plane, of which one far off counts no more than a wave
// with the heights' own median could reach: a gouge is no wave. `least_m` is the least such reach.
double WavesAbout(const Plane& plane, const std::vector<Height>& heights, double least_m);

}  // namespace enamel::scoring
