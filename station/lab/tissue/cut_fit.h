#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/math/vec.h"

// A tissue's resistance to cutting, fitted to recorded force and motion. For one engagement
//
//   F = B V + Fc V/|V| while cutting;   nothing is cut while |F| < Fth;   V_tip = V + c dF/dt
//
// F is the pressing force (along the motion), V the speed of the cutting front, B symmetric and
// positive semi-definite, Fc the Coulomb part, Fth >= Fc the threshold, c the tip's compliance.
// Units: s, mm, N. Frame: the recording's own. No function here keeps state; not for the tick.
//
// Method, and its sources of error:
// * Weak form. With a smooth bump w over a window W, the mean of V is -int w' x and that of F is
//   int w F. Both sides of F = B V are averaged alike: the window adds no bias to B. It adds one to
//   Fc where the motion turns inside it (`turn_bias`); windows that turn, stop or reverse are left
//   out. W: the shortest that brings the noise of a speed under 4 % and holds 3.5 encoder counts at
//   a third of the usual speed (50 ms and 8 samples to 0.6 s).
// * Errors in V shrink B. Their variance: white noise from third differences, and an encoder's
//   counts (half a count per window squared up to 1.5 counts in it, falling with the fourth power
//   above). Their effect on V, on V/|V| and on products of both is removed from the normal
//   equations to second order. The variance is known only to a factor, so twice `attenuation` is
//   added to every interval on both sides.
// * Outliers: single samples far from the median of five are dropped; windows have Huber weights (2
//   medians of the residual) and are left out beyond 8.
// * Fth: the gate whose motion, computed from the force, is nearest to the measured motion, over
//   longer windows (up to 0.8 s), both sticking and cutting.
// * Intervals: 95 %, Student's, over 20 stretches of the recording each left out once (jackknife):
//   neighbouring windows need not be independent.
namespace enamel::station::lab {

struct CutSample {
  double t_s = 0;
  dvec3 x_mm{0}, f_n{0};
  dvec3 axis{0};  // the bur's, any length; zero: not known
  int run = 0;    // samples of another run are never in one window
};

struct Estimate {
  double value = 0, low = 0, high = 0;  // 95 % interval
};

enum class CutModel {
  kNone,
  kScalar,        // one B, along the motion
  kAxialLateral,  // across and along the bur's axis
  kMatrix,
};

// A window that was used.
struct CutPoint {
  double speed_mm_s = 0, force_n = 0;  // along the motion
  std::optional<double> across_n;      // across motion and the bur's axis, where they are not alike
};

// Use of the samples. Windows overlap by half, so a sample may be in two.
struct CutWindows {
  size_t used = 0;
  size_t gap = 0;      // rows missing inside
  size_t air = 0;      // moving without force, and the window on either side
  size_t slow = 0;     // stuck, or too slow for the resolution
  size_t turning = 0;  // reverses, stops or turns inside
  size_t outlier = 0;  // weight 0
};

struct CutFit {
  CutModel model = CutModel::kNone;
  bool with_coulomb = false;          // false: speeds alike, the line was drawn through the origin
  Estimate b;                         // N s/mm: the scalar; across the axis; a third of the trace
  Estimate axial;                     // kAxialLateral
  std::array<Estimate, 6> matrix;     // kMatrix: xx, yy, zz, xy, xz, yz
  std::array<double, 3> principal{};  // kMatrix: eigenvalues, ascending, none below 0
  double offset_n = 0;                // Fc before it is held at 0 or above
  Estimate coulomb_n;                 // never below 0
  Estimate threshold_n;               // never below Coulomb's part
  bool threshold_seen = false;   // false: no sticking seen; the interval's upper end is a bound
  Estimate compliance_mm_per_n;  // 0 if indistinguishable from 0
  double residual_rms_n = 0;
  double window_s = 0;
  double speed_noise_mm_s = 0;  // one standard deviation of a window's speed, mean of the used
  double attenuation = 0;       // part of B lost to errors in V, restored
  double turn_bias = 0;         // largest part of Fc that turning inside windows can hide
  double condition = 0;         // of the scaled normal equations; above 400 a model is not taken
  double speed_max_mm_s = 0, force_max_n = 0;
  size_t samples = 0, spikes = 0;  // spikes: single samples dropped
  CutWindows windows;
  std::vector<CutPoint> points;  // used windows
  // Windows in which force and speed stay alike, also those below a threshold that is B's own: of a root they are its lower end.
  std::vector<CutPoint> feeds;
  std::vector<std::string> warnings;
  std::string refused;  // why there is no fit
};

// `magnitude`: f_n.x is a force along the motion without direction. `positions`: number of recorded
// axes of x, y, z. Time rises within a run. Requires: numbers finite.
CutFit FitCut(const std::vector<CutSample>& samples, double dt_s, bool magnitude, int positions);

// Speed of the cutting front under force `f` (N): the inverse of the law above, 0 below
// `coulomb_n`. `basis` has B's eigenvectors as columns, `values` its eigenvalues (above 0), N s/mm.
dvec3 FrontSpeed(const dvec3& f, const dmat3& basis, const dvec3& values, double coulomb_n);

}  // namespace enamel::station::lab
