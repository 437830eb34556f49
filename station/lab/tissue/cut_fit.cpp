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
constexpr double kMaxCondition = 400;
// A millimetre under a newton is too soft for a tip.
constexpr double kMaxCompliance_mm_per_n = 1;

std::string F(double v, const char* format = "%.3g") {
  char text[64];
  std::snprintf(text, sizeof text, format, v);
  return text;
}

// One fit. The steps that return a bool return false once nothing is left to fit; `refused` then
// says why, or Fit does.
class Fitter {
 public:
  explicit Fitter(bool magnitude) : magnitude_(magnitude) {}

  CutFit Fit(const std::vector<CutSample>& samples, double dt_s, int positions) {
    if (Record(samples, dt_s) && IsACut() && Begin(positions)) {
      Settle();
      if (s_.ok)
        s_ = SolvePlan(r_, ladder_[std::min(rung_, ladder_.size() - 1)], windows_, c_, {}, true);
      if (!s_.ok || fit_.windows.used < kMinWindows) {
        Refuse("the equations have no solution: " + std::to_string(fit_.windows.used) +
               " windows, too little change of speed and direction");
      } else {
        Report();
      }
    }
    return std::move(fit_);
  }

 private:
  bool Refuse(std::string why) {
    fit_.refused = std::move(why);
    return false;
  }

  bool Record(const std::vector<CutSample>& samples, double dt_s) {
    fit_.samples = samples.size();
    std::vector<CutSample> kept = samples;
    if (magnitude_) {
      for (CutSample& s : kept) s.f_n = dvec3(std::fabs(s.f_n.x), 0, 0);
    }
    // Before measuring: one spike of a sensor would set noise, window and contact.
    fit_.spikes = DropSpikes(&kept);
    if (kept.size() < kMinSamples) {
      return Refuse("only " + std::to_string(kept.size()) + " samples; at least " +
                    std::to_string(kMinSamples) + " are needed");
    }
    r_ = RecordingOf(std::move(kept), dt_s, magnitude_);
    fit_.window_s = r_.window_s;
    windows_ = WindowsOf(r_, r_.window_s);
    return true;
  }

  // Most faulty files have a wrong unit or column: reported with the expected value, before a fit
  // uses it.
  bool IsACut() {
    double power = 0, fastest = 0, strongest = 0;
    for (const Window& w : windows_) {
      if (w.whole.gap) continue;
      power += Dot(w.whole.f, w.whole.v);
      fastest = std::max(fastest, glm::length(w.whole.v));
      strongest = std::max(strongest, glm::length(w.whole.f));
    }
    if (windows_.empty()) {
      return Refuse("no window of " + F(fit_.window_s) + " s without missing rows; at least " +
                    std::to_string(kMinWindows) + " windows are needed");
    }
    if (fastest < 1e-3) {
      return Refuse("no motion: the fastest window moves at " + F(fastest) +
                    " mm/s; record while cutting");
    }
    if (fastest > 1000) {
      return Refuse("a speed of " + F(fastest, "%.4g") +
                    " mm/s: expected below 1 m/s; check the units of position and time");
    }
    if (strongest < kContact_n) {
      return Refuse("no contact: the largest force is " + F(strongest) + " N; expected above " +
                    F(kContact_n) + " N");
    }
    // Cutting takes work: F and V point the same way when F is the hand's. Sensors are mounted
    // either way.
    if (!magnitude_ && power < 0) {
      for (CutSample& s : r_.s) s.f_n = -s.f_n;
      windows_ = WindowsOf(r_, r_.window_s);
      fit_.warnings.push_back("force points against the motion: taken as the tooth's, and turned");
    }
    return true;
  }

  // The richest model first. Nothing is guessed: if the recording cannot determine it, a simpler
  // model is tried, with a note.
  bool Begin(int positions) {
    SmoothForce(&r_);
    const bool has_axis = std::all_of(r_.s.begin(), r_.s.end(),
                                      [](const CutSample& s) { return glm::length(s.axis) > 0; });
    if (positions == 3) {
      ladder_.push_back(
          PlanOf(has_axis ? CutModel::kAxialLateral : CutModel::kMatrix, true, false, magnitude_));
    }
    ladder_.push_back(PlanOf(CutModel::kScalar, true, false, true));
    // The last model has one unknown, which every motion determines.
    ladder_.push_back(PlanOf(CutModel::kScalar, false, false, true));
    Classify(r_, 0, 0, &windows_, &fit_);
    if (fit_.windows.used < kMinWindows) {
      return Refuse("only " + std::to_string(fit_.windows.used) + " windows of " +
                    F(fit_.window_s) + " s are in contact and moving steadily; at least " +
                    std::to_string(kMinWindows) + " are needed");
    }
    // Sticking is slow: windows of B's length hold no count of it.
    width_ = magnitude_ ? r_.window_s : std::max(r_.window_s, std::min(4 * r_.window_s, 0.8));
    longer_ = WindowsOf(r_, width_);
    return true;
  }

  // Compliance, threshold and B each depend on the windows that the others let through. Two rounds
  // that agree end it; six is a bound. The first round ignores the tip's bending and the threshold.
  void Settle() {
    for (int round = 0; round < 6; ++round) {
      const double c_before = c_, threshold_before = threshold_;
      Classify(r_, c_, threshold_, &windows_, &fit_);
      // A threshold that leaves no windows is wrong: without it a fit is at least possible.
      if (fit_.windows.used < kMinWindows && threshold_ > 0) {
        threshold_ = 0;
        Classify(r_, c_, threshold_, &windows_, &fit_);
      }
      if (fit_.windows.used < kMinWindows || !Descend()) return;
      if (bends_ && !Bend(round)) return;
      FindThreshold();
      if (round > 0 && std::fabs(c_ - c_before) <= 0.01 * c_ &&
          std::fabs(threshold_ - threshold_before) <= 0.01 * threshold_)
        return;
    }
  }

  // To the first model that the windows determine.
  bool Descend() {
    for (; rung_ < ladder_.size(); ++rung_) {
      s_ = SolvePlan(r_, ladder_[rung_], windows_, c_, {}, false);
      if (s_.ok && s_.condition <= kMaxCondition) return true;
      if (rung_ + 1 == ladder_.size()) return s_.ok;
      std::string why = "condition number " + F(s_.ok ? s_.condition : 1e99, "%.2g");
      if (!s_.ok || !(s_.condition < 1e6)) why = "they leave it undetermined";
      if (ladder_[rung_].model == CutModel::kScalar) {
        fit_.warnings.push_back("speeds are too much alike to tell B from Coulomb's part (" + why +
                                "): B is drawn through the origin and holds both; record at speeds "
                                "that differ by a factor of two or more");
      } else {
        fit_.warnings.push_back("the directions of motion do not determine " +
                                std::string(ladder_[rung_].model == CutModel::kMatrix
                                                ? "a matrix B"
                                                : "B along and across the bur") +
                                " (" + why +
                                "): one B along the motion is given; record cuts in at least three "
                                "directions that are not in a plane");
      }
    }
    return false;
  }

  bool Bend(int round) {
    Plan plan = ladder_[rung_];
    plan.compliance = true;
    const Solved with = SolvePlan(r_, plan, windows_, c_, s_.fit.x, true);
    if (!with.ok) return true;
    const Estimate e = Interval(
        with, [&](const Column& x) { return c_ + x[plan.columns() - 1]; }, 0);
    double next = std::clamp(e.value, 0.0, kMaxCompliance_mm_per_n);
    // Three standard errors: fitting an insignificant bend only adds noise.
    if (e.value < (e.value - e.low) * 1.5) {
      // Not significant twice: given up, so that noise does not switch it on and off.
      if (round > 0) bends_ = false;
      next = 0;
    }
    fit_.compliance_mm_per_n = {next, std::max(0.0, e.low), std::max(0.0, e.high)};
    if (next == c_) return true;
    c_ = next;
    Classify(r_, c_, threshold_, &windows_, &fit_);
    return Descend();
  }

  void FindThreshold() {
    const Plan& p = s_.plan;
    double noise = 0;
    for (const Window* w : s_.used)
      noise += std::sqrt(w->variance.x + w->variance.y + w->variance.z);
    fit_.speed_noise_mm_s = noise / static_cast<double>(s_.used.size());
    fit_.coulomb_n = {p.coulomb ? std::max(0.0, s_.fit.x[p.damping]) : 0, 0, 0};
    dvec3 axis = s_.used.front()->axis;
    axis = glm::length(axis) > 0 ? glm::normalize(axis) : dvec3(0, 0, 1);
    dmat3 b = Damping(p, s_.fit.x, axis), basis(1);
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
    FitThreshold(r_, windows_, longer_, width_, basis, principal, c_, &fit_);
    threshold_ = fit_.threshold_seen ? fit_.threshold_n.value : 0;
  }

  void Report() {
    const Plan& p = s_.plan;
    double mean_b = s_.fit.x[0];
    if (p.model == CutModel::kMatrix) mean_b = (s_.fit.x[0] + s_.fit.x[1] + s_.fit.x[2]) / 3;
    // The noise's variance is known only to a factor (cut_fit.h), so its whole effect is added on
    // both sides.
    const double trust = 2 * s_.attenuation * std::fabs(mean_b);
    fit_.model = p.model;
    fit_.with_coulomb = p.coulomb;
    fit_.condition = s_.condition;
    fit_.residual_rms_n = s_.residual;
    fit_.attenuation = s_.attenuation;
    fit_.windows.outlier = s_.outliers;
    fit_.windows.used -= s_.outliers;
    ReportB(trust);
    if (p.coulomb) ReportCoulomb(trust);
    // Fth >= Fc by definition: below Fc nothing moves either.
    fit_.threshold_n.value = std::max(fit_.threshold_n.value, fit_.coulomb_n.value);
    fit_.threshold_n.high = std::max(fit_.threshold_n.high, fit_.threshold_n.value);
    if (!fit_.threshold_seen)
      fit_.warnings.push_back(
          "no sticking was seen that a threshold above Coulomb's part would "
          "explain: it lies below " +
          F(fit_.threshold_n.high) + " N; record slow presses and stops as well");
    if (p.model == CutModel::kMatrix) ReportPrincipal();
    for (size_t k = 0; k < s_.used.size(); ++k) {
      const Window& w = *s_.used[k];
      if (s_.weight[k] > 0) fit_.points.push_back({glm::length(w.v), Along(r_, w), Across(w)});
    }
    ReportFeeds();
    // Even the upper end: a B that may be positive is a poor fit, but not a wrong file.
    if (fit_.b.high <= 0)
      Refuse("force falls with speed (B = " + F(fit_.b.value, "%.3f") +
             " N s/mm): position and force do not belong together, or not in this unit");
  }

  void ReportFeeds() {
    std::vector<Window> all = windows_;
    CutFit counts;
    Classify(r_, c_, 0, &all, &counts);
    for (const Window& w : all) {
      // The mean of a root is not the root of the mean: where the force changes by a tenth, by 0.1 %.
      const double change_n = glm::length(w.late.f - w.early.f);
      if (w.used && change_n <= 0.1 * glm::length(w.whole.f))
        fit_.feeds.push_back({glm::length(w.v), Along(r_, w), Across(w)});
    }
  }

  std::optional<double> Across(const Window& w) const {
    const dvec3 side = glm::cross(w.axis, w.v);
    const double size = glm::length(side);
    // Within 45 degrees of the axis the end cuts.
    if (magnitude_ || !(size > 0.7 * glm::length(w.axis) * glm::length(w.v)) || !(size > 0))
      return {};
    return Dot(w.whole.f, side) / size;
  }

  void ReportB(double trust) {
    if (s_.plan.model == CutModel::kMatrix) {
      for (int j = 0; j < 6; ++j)
        fit_.matrix[j] = Interval(
            s_, [&](const Column& x) { return x[j]; }, trust);
      fit_.b = Interval(
          s_, [](const Column& x) { return (x[0] + x[1] + x[2]) / 3; }, trust);
      return;
    }
    fit_.b = Interval(
        s_, [](const Column& x) { return x[0]; }, trust);
    if (s_.plan.model == CutModel::kAxialLateral)
      fit_.axial = Interval(
          s_, [](const Column& x) { return x[1]; }, trust);
  }

  void ReportCoulomb(double trust) {
    const int at = s_.plan.damping;
    const double turn = fit_.turn_bias * std::fabs(s_.fit.x[at]);
    fit_.coulomb_n = Interval(
        s_, [&](const Column& x) { return x[at]; }, turn + trust * s_.speed);
    fit_.offset_n = fit_.coulomb_n.value;
    fit_.coulomb_n.value = std::max(0.0, fit_.coulomb_n.value);
    fit_.coulomb_n.low = std::max(0.0, fit_.coulomb_n.low);
    fit_.coulomb_n.high = std::max(0.0, fit_.coulomb_n.high);
    if (fit_.offset_n < 0 && -fit_.offset_n > 0.05 * fit_.force_max_n)
      fit_.warnings.push_back("the line meets the axis at " + F(fit_.offset_n) +
                              " N, below 0: speed rises less than force; check units and contact");
  }

  void ReportPrincipal() {
    Square m, vectors;
    Column values{};
    m.n = 3;
    constexpr int kRow[] = {0, 1, 2, 0, 0, 1}, kColumn[] = {0, 1, 2, 1, 2, 2};
    for (int j = 0; j < 6; ++j)
      m.a[kRow[j]][kColumn[j]] = m.a[kColumn[j]][kRow[j]] = fit_.matrix[j].value;
    Eigen(m, &values, &vectors);
    // Noise can make a small eigenvalue negative. The interval contains both the fitted and the
    // used value.
    if (values[0] < 0) {
      fit_.warnings.push_back("an eigenvalue of B came out at " + F(values[0]) +
                              " N s/mm and was set to 0: B must not push");
      for (int j = 0; j < 6; ++j) {
        double sum = 0;
        for (int k = 0; k < 3; ++k)
          sum += vectors.a[kRow[j]][k] * std::max(0.0, values[k]) * vectors.a[kColumn[j]][k];
        fit_.matrix[j].value = sum;
        fit_.matrix[j].low = std::min(fit_.matrix[j].low, sum);
        fit_.matrix[j].high = std::max(fit_.matrix[j].high, sum);
      }
    }
    for (int k = 0; k < 3; ++k) fit_.principal[k] = std::max(0.0, values[k]);
  }

  const bool magnitude_;
  CutFit fit_;
  Recording r_;
  std::vector<Window> windows_, longer_;  // for B, and for the threshold: of width_
  double width_ = 0;
  std::vector<Plan> ladder_;
  size_t rung_ = 0;
  Solved s_;  // of the model on this rung
  double c_ = 0, threshold_ = 0;
  bool bends_ = true;
};

}  // namespace

CutFit FitCut(const std::vector<CutSample>& samples, double dt_s, bool magnitude, int positions) {
  return Fitter(magnitude).Fit(samples, dt_s, positions);
}

}  // namespace enamel::station::lab
