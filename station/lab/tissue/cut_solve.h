#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "station/lab/tissue/cut_windows.h"
#include "station/lab/tissue/small_matrix.h"
#include "station/lab/tissue/statistics.h"

// B, Coulomb's part and the tip's compliance from classified windows: weighted least squares with
// the noise of V taken out, Huber's weights, a jackknife for the intervals (cut_fit.h). Pure
// functions, any thread.
namespace enamel::station::lab::cut {

constexpr size_t kMinWindows = 8;          // for a fit
constexpr size_t kGroups = 20;             // stretches of the jackknife
constexpr double kHuber = 2, kReject = 8;  // in medians of the residual

// Which unknowns are fitted.
struct Plan {
  CutModel model = CutModel::kScalar;
  bool coulomb = true, compliance = false;
  bool along = false;  // one equation a window, along the motion
  int damping = 1;     // columns of B
  int columns() const { return damping + coulomb + compliance; }
};

Plan PlanOf(CutModel model, bool coulomb, bool compliance, bool along);

// B of the unknowns `x` in a window whose bur has this axis (unit length).
dmat3 Damping(const Plan& p, const Column& x, const dvec3& axis);

struct Linear {
  Column x{};
  Square normal;
  double median = 0;  // of the residual's size
  bool ok = false;
};

struct Solved {
  Plan plan;
  Linear fit;
  std::vector<Column> without;  // jackknife
  std::vector<double> weight;
  std::vector<const Window*> used;
  double condition = 0, residual = 0, attenuation = 0, speed = 0;
  double compliance = 0;
  size_t outliers = 0;
  bool ok = false;
};

// From the used windows. `c`: the compliance taken so far; `at`: unknowns that a further part of it
// is taken about. Not ok: fewer than kMinWindows, or no solution.
Solved SolvePlan(const Recording& r, const Plan& plan, const std::vector<Window>& windows, double c,
                 const Column& at, bool jackknife);

// Half the 95 % interval of a linear combination of the unknowns.
template <class Of>
Estimate Interval(const Solved& s, Of of, double extra) {
  double n = static_cast<double>(s.without.size()), mean = 0, sum = 0;
  for (const Column& x : s.without) mean += of(x) / n;
  for (const Column& x : s.without) sum += (of(x) - mean) * (of(x) - mean);
  double value = of(s.fit.x);
  double half = Student975(n - 1) * std::sqrt(sum * (n - 1) / n) + extra;
  return {value, value - half, value + half};
}

}  // namespace enamel::station::lab::cut
