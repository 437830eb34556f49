#pragma once

#include <string>
#include <vector>

#include "common/cutting/tissue.h"
#include "station/lab/tissue/cut_fit.h"

// Whether a recorded cut was one by load: F = F0 + k v^m with m 1/2 or 1, and a friction mu of the turning bur that pushes
// across the motion. Units: mm, s, N. Pure functions, any thread.
//
// Method: the windows that cut steadily (cut_fit.h), least squares for each m with F0 at least 0, and a
// jackknife over 20 stretches of the recording. An exponent is told where the other one's mean squared error is
// larger by more than the 95 % interval of the difference; else the data does not hold it. mu is the sum of the
// forces across over the sum of those along: over a front that is alike on both sides that is mu itself
// (cutting/engagement.h). Sources of error: an uneven front, and a window's noise of speed, which the root halves.
namespace enamel::station::lab {

struct LoadFit {
  bool exponent_told = false;
  cutting::FeedExponent exponent = cutting::FeedExponent::kOne;
  double feed_mm_s = 0;                // v0: the median of the speeds
  Estimate coulomb_n, at_feed_n;       // F0, k v0^m
  double residual_n = 0, other_n = 0;  // RMS with this exponent, and with the other
  bool friction_told = false;
  Estimate friction;
  std::string why_no_exponent, why_no_friction;  // empty where told
};

// Requires: at least 20 points, in the order of time.
LoadFit FitLoad(const std::vector<CutPoint>& points);

}  // namespace enamel::station::lab
