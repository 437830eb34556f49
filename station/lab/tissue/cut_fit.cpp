#include "station/lab/tissue/cut_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "station/lab/tissue/cut_solve.h"
#include "station/lab/tissue/cut_threshold.h"
#include "station/lab/tissue/cut_windows.h"
#include "station/lab/tissue/small_matrix.h"

namespace enamel::station::lab {
namespace {

using namespace cut;

// Of normal equations, hence 20 of the columns themselves: one unknown is then twenty times less
// certain than another.
constexpr double kMostCondition = 400;
// A millimetre under a newton is too soft for a tip.
constexpr double kMostCompliance_mm_per_n = 1;

std::string F(double v, const char* format = "%.3g") {
  char text[64];
  std::snprintf(text, sizeof text, format, v);
  return text;
}

}  // namespace

CutFit FitCut(const std::vector<CutSample>& samples, double dt_s, bool magnitude, int positions) {
  CutFit fit;
  fit.samples = samples.size();
  std::vector<CutSample> kept = samples;
  if (magnitude) {
    for (CutSample& s : kept) s.f_n = dvec3(std::fabs(s.f_n.x), 0, 0);
  }
  // Before measuring: one spike of a sensor would set noise, window and contact.
  fit.spikes = DropSpikes(&kept);
  if (kept.size() < kLeastSamples) {
    fit.refused = "only " + std::to_string(kept.size()) + " samples; at least " +
                  std::to_string(kLeastSamples) + " are needed";
    return fit;
  }
  Recording r = RecordingOf(std::move(kept), dt_s, magnitude);
  fit.window_s = r.window_s;
  std::vector<Window> windows = WindowsOf(r, r.window_s);
  double power = 0, fastest = 0, strongest = 0;
  for (const Window& w : windows) {
    if (w.whole.gap) continue;
    power += Dot(w.whole.f, w.whole.v);
    fastest = std::max(fastest, glm::length(w.whole.v));
    strongest = std::max(strongest, glm::length(w.whole.f));
  }
  if (windows.empty()) {
    fit.refused = "no window of " + F(fit.window_s) + " s without missing rows; at least " +
                  std::to_string(kLeastWindows) + " windows are needed";
    return fit;
  }
  // Most faulty files have a wrong unit or column: reported with the expected value, before a fit
  // uses it.
  if (fastest < 1e-3) {
    fit.refused =
        "no motion: the fastest window moves at " + F(fastest) + " mm/s; record while cutting";
    return fit;
  }
  if (fastest > 1000) {
    fit.refused = "a speed of " + F(fastest, "%.4g") +
                  " mm/s: expected below 1 m/s; check the units of position and time";
    return fit;
  }
  if (strongest < kContact_n) {
    fit.refused = "no contact: the largest force is " + F(strongest) + " N; expected above " +
                  F(kContact_n) + " N";
    return fit;
  }
  // Cutting takes work: F and V point the same way when F is the hand's. Sensors are mounted either
  // way.
  if (!magnitude && power < 0) {
    for (CutSample& s : r.s) s.f_n = -s.f_n;
    windows = WindowsOf(r, r.window_s);
    fit.warnings.push_back("force points against the motion: taken as the tooth's, and turned");
  }
  SmoothForce(&r);

  bool has_axis = std::all_of(r.s.begin(), r.s.end(),
                              [](const CutSample& s) { return glm::length(s.axis) > 0; });
  // The richest model first. Nothing is guessed: if the recording cannot determine it, a simpler
  // model is tried, with a note.
  std::vector<Plan> ladder;
  if (positions == 3 && has_axis)
    ladder.push_back(PlanOf(CutModel::kAxialLateral, true, false, magnitude));
  else if (positions == 3)
    ladder.push_back(PlanOf(CutModel::kMatrix, true, false, magnitude));
  ladder.push_back(PlanOf(CutModel::kScalar, true, false, true));
  // The last model has one unknown, which every motion determines.
  ladder.push_back(PlanOf(CutModel::kScalar, false, false, true));

  double c = 0, threshold = 0;
  Classify(r, 0, 0, &windows, &fit);
  if (fit.windows.used < kLeastWindows) {
    fit.refused = "only " + std::to_string(fit.windows.used) + " windows of " + F(fit.window_s) +
                  " s are in contact and moving steadily; at least " +
                  std::to_string(kLeastWindows) + " are needed";
    return fit;
  }
  size_t rung = 0;
  Solved s;
  auto Descend = [&] {
    for (; rung < ladder.size(); ++rung) {
      s = SolvePlan(r, ladder[rung], windows, c, {}, false);
      if (s.ok && s.condition <= kMostCondition) return true;
      if (rung + 1 == ladder.size()) return s.ok;
      std::string why = "condition number " + F(s.ok ? s.condition : 1e99, "%.2g");
      if (!s.ok || !(s.condition < 1e6)) why = "they leave it undetermined";
      if (ladder[rung].model == CutModel::kScalar) {
        fit.warnings.push_back("speeds are too much alike to tell B from Coulomb's part (" + why +
                               "): B is drawn through the origin and holds both; record at speeds "
                               "that differ by a factor of two or more");
      } else {
        fit.warnings.push_back("the directions of motion do not determine " +
                               std::string(ladder[rung].model == CutModel::kMatrix
                                               ? "a matrix B"
                                               : "B along and across the bur") +
                               " (" + why +
                               "): one B along the motion is given; record cuts in at least three "
                               "directions that are not in a plane");
      }
    }
    return false;
  };
  // A second pass corrects for the tip's bending and the threshold, which the first ignores.
  // Sticking is slow: windows of B's length hold no count of it.
  double width = magnitude ? r.window_s : std::max(r.window_s, std::min(4 * r.window_s, 0.8));
  std::vector<Window> longer = WindowsOf(r, width);
  bool bends = true;
  double bend_sure = 0;
  // Compliance, threshold and B each depend on the windows that the others let through. Two rounds
  // that agree end it; six is a bound.
  for (int round = 0; round < 6; ++round) {
    double c_before = c, threshold_before = threshold;
    Classify(r, c, threshold, &windows, &fit);
    // A threshold that leaves no windows is wrong: without it a fit is at least possible.
    if (fit.windows.used < kLeastWindows && threshold > 0) {
      threshold = 0;
      Classify(r, c, threshold, &windows, &fit);
    }
    if (fit.windows.used < kLeastWindows || !Descend()) break;
    if (bends) {
      Plan plan = ladder[rung];
      plan.compliance = true;
      Solved with = SolvePlan(r, plan, windows, c, s.fit.x, true);
      if (with.ok) {
        Estimate e = Interval(
            with, [&](const Column& x) { return c + x[plan.columns() - 1]; }, 0);
        double next = std::clamp(e.value, 0.0, kMostCompliance_mm_per_n);
        // Three standard errors: fitting an insignificant bend only adds noise.
        bend_sure = (e.value - e.low) * 1.5;
        if (e.value < bend_sure) {
          // Not significant twice: given up, so that noise does not switch it on and off.
          if (round > 0) bends = false;
          next = 0;
        }
        fit.compliance_mm_per_n = {next, std::max(0.0, e.low), std::max(0.0, e.high)};
        if (next != c) {
          c = next;
          Classify(r, c, threshold, &windows, &fit);
          if (!Descend()) break;
        }
      }
    }
    const Plan& p = s.plan;
    double noise = 0;
    for (const Window* w : s.used)
      noise += std::sqrt(w->variance.x + w->variance.y + w->variance.z);
    fit.speed_noise_mm_s = noise / static_cast<double>(s.used.size());
    fit.coulomb_n = {p.coulomb ? std::max(0.0, s.fit.x[p.damping]) : 0, 0, 0};
    dvec3 axis = s.used.front()->axis;
    axis = glm::length(axis) > 0 ? glm::normalize(axis) : dvec3(0, 0, 1);
    dmat3 b = Damping(p, s.fit.x, axis), basis(1);
    Square m, vectors;
    Column values{};
    m.n = 3;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) m.a[i][j] = b[i][j];
    }
    Eigen(m, &values, &vectors);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) basis[j][i] = vectors.a[i][j];
    }
    double most = std::max(values[2], 1e-9);
    // Above 0, since FrontSpeed divides by them.
    dvec3 principal(std::max(values[0], 1e-3 * most), std::max(values[1], 1e-3 * most), most);
    FitThreshold(r, windows, longer, width, basis, principal, c, &fit);
    threshold = fit.threshold_seen ? fit.threshold_n.value : 0;
    if (round > 0 && std::fabs(c - c_before) <= 0.01 * c &&
        std::fabs(threshold - threshold_before) <= 0.01 * threshold)
      break;
  }
  if (s.ok) s = SolvePlan(r, ladder[std::min(rung, ladder.size() - 1)], windows, c, {}, true);
  if (!s.ok || fit.windows.used < kLeastWindows) {
    fit.refused = "the equations have no solution: " + std::to_string(fit.windows.used) +
                  " windows, too little change of speed and direction";
    return fit;
  }

  const Plan& p = s.plan;
  double mean_b = s.fit.x[0];
  if (p.model == CutModel::kMatrix) mean_b = (s.fit.x[0] + s.fit.x[1] + s.fit.x[2]) / 3;
  // The noise's variance is known only to a factor (cut_fit.h), so its whole effect is added on
  // both sides.
  double trust = 2 * s.attenuation * std::fabs(mean_b);
  fit.model = p.model;
  fit.with_coulomb = p.coulomb;
  fit.condition = s.condition;
  fit.residual_rms_n = s.residual;
  fit.attenuation = s.attenuation;
  fit.windows.outlier = s.outliers;
  fit.windows.used -= s.outliers;
  if (p.model == CutModel::kMatrix) {
    for (int j = 0; j < 6; ++j)
      fit.matrix[j] = Interval(
          s, [&](const Column& x) { return x[j]; }, trust);
    fit.b = Interval(
        s, [](const Column& x) { return (x[0] + x[1] + x[2]) / 3; }, trust);
  } else {
    fit.b = Interval(
        s, [](const Column& x) { return x[0]; }, trust);
    if (p.model == CutModel::kAxialLateral)
      fit.axial = Interval(
          s, [](const Column& x) { return x[1]; }, trust);
  }
  if (p.coulomb) {
    double turn = fit.turn_bias * std::fabs(s.fit.x[p.damping]);
    fit.coulomb_n = Interval(
        s, [&](const Column& x) { return x[p.damping]; }, turn + trust * s.speed);
    fit.offset_n = fit.coulomb_n.value;
    fit.coulomb_n.value = std::max(0.0, fit.coulomb_n.value);
    fit.coulomb_n.low = std::max(0.0, fit.coulomb_n.low);
    fit.coulomb_n.high = std::max(0.0, fit.coulomb_n.high);
    if (fit.offset_n < 0 && -fit.offset_n > 0.05 * fit.force_max_n)
      fit.warnings.push_back("the line meets the axis at " + F(fit.offset_n) +
                             " N, below 0: speed rises less than force; check units and contact");
  }
  // Fth >= Fc by definition: below Fc nothing moves either.
  fit.threshold_n.value = std::max(fit.threshold_n.value, fit.coulomb_n.value);
  fit.threshold_n.high = std::max(fit.threshold_n.high, fit.threshold_n.value);
  if (!fit.threshold_seen)
    fit.warnings.push_back(
        "no sticking was seen that a threshold above Coulomb's part would "
        "explain: it lies below " +
        F(fit.threshold_n.high) + " N; record slow presses and stops as well");
  if (p.model == CutModel::kMatrix) {
    Square m, vectors;
    Column values{};
    m.n = 3;
    constexpr int kRow[] = {0, 1, 2, 0, 0, 1}, kColumn[] = {0, 1, 2, 1, 2, 2};
    for (int j = 0; j < 6; ++j)
      m.a[kRow[j]][kColumn[j]] = m.a[kColumn[j]][kRow[j]] = fit.matrix[j].value;
    Eigen(m, &values, &vectors);
    // Noise can make a small eigenvalue negative. The interval contains both the fitted and the
    // used value.
    if (values[0] < 0) {
      fit.warnings.push_back("an eigenvalue of B came out at " + F(values[0]) +
                             " N s/mm and was set to 0: B must not push");
      constexpr int kR[] = {0, 1, 2, 0, 0, 1}, kC[] = {0, 1, 2, 1, 2, 2};
      for (int j = 0; j < 6; ++j) {
        double sum = 0;
        for (int k = 0; k < 3; ++k)
          sum += vectors.a[kR[j]][k] * std::max(0.0, values[k]) * vectors.a[kC[j]][k];
        fit.matrix[j].value = sum;
        fit.matrix[j].low = std::min(fit.matrix[j].low, sum);
        fit.matrix[j].high = std::max(fit.matrix[j].high, sum);
      }
    }
    for (int k = 0; k < 3; ++k) fit.principal[k] = std::max(0.0, values[k]);
  }
  for (size_t k = 0; k < s.used.size(); ++k) {
    if (s.weight[k] > 0) fit.points.push_back({glm::length(s.used[k]->v), Along(r, *s.used[k])});
  }
  // Even the upper end: a B that may be positive is a poor fit, but not a wrong file.
  if (fit.b.high <= 0)
    fit.refused = "force falls with speed (B = " + F(fit.b.value, "%.3f") +
                  " N s/mm): position and force do not belong together, or not in this unit";
  return fit;
}

}  // namespace enamel::station::lab
