#include "station/lab/tissue/cut_threshold.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "station/lab/tissue/cut_solve.h"

namespace enamel::station::lab {

dvec3 FrontSpeed(const dvec3& f, const dmat3& basis, const dvec3& values, double coulomb_n) {
  double size = glm::length(f);
  if (!(size > coulomb_n)) return dvec3(0);
  dvec3 g(Dot(f, basis[0]), Dot(f, basis[1]), Dot(f, basis[2]));
  // (B + s) V = F with s |V| = Fc: s |V(s)| rises from 0 to |F|.
  auto At = [&](double s) { return g / (values + dvec3(s)); };
  double s = 0;
  if (coulomb_n > 0) {
    double least = std::min({values.x, values.y, values.z}),
           most = std::max({values.x, values.y, values.z});
    // With all eigenvalues at the least, or at the most: s is between the two results.
    double low = least * coulomb_n / (size - coulomb_n),
           high = most * coulomb_n / (size - coulomb_n);
    s = low;
    for (int i = 0; i < 30; ++i) {
      dvec3 v = At(s);
      double speed = glm::length(v), off = s * speed - coulomb_n;
      (off < 0 ? low : high) = s;
      if (std::fabs(off) <= 1e-10 * coulomb_n) break;
      double slope = Dot(v * v, values / (values + dvec3(s))) / speed;
      s -= off / slope;
      // Newton, kept inside its bracket by halving.
      if (!(s > low && s < high)) s = 0.5 * (low + high);
    }
  }
  dvec3 v = At(s);
  return v.x * basis[0] + v.y * basis[1] + v.z * basis[2];
}

namespace cut {
namespace {

constexpr size_t kGrid = 80;

}  // namespace

void FitThreshold(const Recording& r, const std::vector<Window>& windows,
                  const std::vector<Window>& longer, double width, const dmat3& basis,
                  const dvec3& values, double c, CutFit* fit) {
  fit->threshold_seen = false;
  double floor = fit->coulomb_n.value;
  std::vector<char> air(r.s.size(), 0);
  for (const Window& w : windows) {
    for (size_t i = w.first; !w.steady && !w.whole.gap && i < w.last; ++i) air[i] = 1;
  }
  std::vector<const Window*> all;
  for (const Window& w : longer) {
    bool steady = !w.whole.gap;
    for (size_t i = w.first; steady && i < w.last; ++i) steady = !air[i];
    if (steady) all.push_back(&w);
  }
  double top = 0;
  std::vector<double> forces, miss;
  std::vector<dvec3> speed(r.s.size());
  for (size_t i = 0; i < r.s.size(); ++i) {
    speed[i] = FrontSpeed(r.smooth[i], basis, values, floor);
    forces.push_back(r.smooth_n[i]);
  }
  top = Quantile(forces, 0.9);
  fit->threshold_n = {floor, std::max(0.0, fit->coulomb_n.low),
                      std::max(floor, fit->coulomb_n.high)};
  if (all.size() < kMinWindows || !(top > floor)) return;
  // As wide as the noise of the smoothed force: a sharp gate would make the sum a staircase.
  double soft =
      std::max(r.force_noise_n / std::sqrt(std::max(1.0, 2 * kForceSmooth_s / r.dt)), 1e-3 * top);
  std::vector<std::vector<double>> bump(all.size());
  std::vector<dvec3> seen(all.size()), ungated(all.size());
  std::vector<double> weakest(all.size(), 1e300), hardest(all.size(), 0);
  auto Miss = [&](size_t k, double gate) {
    const Window& w = *all[k];
    dvec3 sum(0);
    // In most windows the gate is fully open or shut: their sums need no loop.
    if (gate < weakest[k] - soft) sum = ungated[k];
    for (size_t i = w.first; gate >= weakest[k] - soft && gate < hardest[k] + soft && i < w.last;
         ++i) {
      double open = std::clamp((r.smooth_n[i] - gate) / (2 * soft) + 0.5, 0.0, 1.0);
      if (open > 0) sum += bump[k][i - w.first] * open * speed[i];
    }
    return r.magnitude ? std::fabs(glm::length(seen[k]) - sum.x) : glm::length(seen[k] - sum);
  };
  for (size_t k = 0; k < all.size(); ++k) {
    const Window& w = *all[k];
    double total = 0;
    for (size_t i = w.first; i < w.last; ++i) {
      double a = 2 * M_PI * (r.s[i].t_s - w.middle_s) / width;
      bump[k].push_back((1 + std::cos(a)) * r.width_s[i]);
      total += bump[k].back();
    }
    for (double& b : bump[k]) b /= total;
    for (size_t i = w.first; i < w.last; ++i) {
      ungated[k] += bump[k][i - w.first] * speed[i];
      weakest[k] = std::min(weakest[k], r.smooth_n[i]);
      hardest[k] = std::max(hardest[k], r.smooth_n[i]);
    }
    seen[k] = Front(r, w.whole, c);
    miss.push_back(Miss(k, floor - 4 * soft));
  }
  // Noise of a window: the median error without any gate, and the resolution's own.
  double scale = std::max(Quantile(miss, 0.5), 1e-6);
  std::vector<double> sharp;
  for (const Window* w : all)
    sharp.push_back(1 / std::sqrt(scale * scale + w->variance.x + w->variance.y + w->variance.z));
  size_t groups = std::min(kGroups, all.size() / 2);
  std::vector<double> total(kGrid + 1), best(groups);
  std::vector<std::vector<double>> part(groups, std::vector<double>(kGrid + 1));
  double low = floor, high = top, step = 0;
  auto Lowest = [&](auto cost) {
    size_t at = 0;
    for (size_t j = 1; j <= kGrid; ++j) at = cost(j) < cost(at) ? j : at;
    double x = low + static_cast<double>(at) * step;
    if (at > 0 && at < kGrid) {
      double l = cost(at - 1) - cost(at), h = cost(at + 1) - cost(at);
      // The lowest point of a parabola through three of the grid.
      if (l + h > 0) x += 0.5 * step * (l - h) / (l + h);
    }
    return x;
  };
  double gain = 0, value = floor, first_low = floor, first_high = floor;
  // Coarse over the whole range, then fine around the best: eighty steps each.
  for (int pass = 0; pass < 2; ++pass) {
    step = (high - low) / kGrid;
    std::fill(total.begin(), total.end(), 0);
    for (auto& p : part) std::fill(p.begin(), p.end(), 0);
    for (size_t k = 0; k < all.size(); ++k) {
      auto& mine = part[k * groups / all.size()];
      for (size_t j = 0; j <= kGrid; ++j) {
        double z = Miss(k, low + static_cast<double>(j) * step) * sharp[k];
        double rho = z < kHuber ? 0.5 * z * z : kHuber * (std::min(z, 2 * kReject) - 0.5 * kHuber);
        mine[j] += rho, total[j] += rho;
      }
    }
    value = Lowest([&](size_t j) { return total[j]; });
    double least = *std::min_element(total.begin(), total.end());
    if (pass == 0) gain = total[0] - least;
    // Values worse by less than 4 (twice 1.92: windows overlap) count as equally good.
    first_low = first_high = value;
    for (size_t j = 0; j <= kGrid; ++j) {
      if (total[j] > least + 4) continue;
      first_low = std::min(first_low, low + static_cast<double>(j) * step);
      first_high = std::max(first_high, low + static_cast<double>(j) * step);
    }
    if (pass == 0) {
      double pad = 3 * step;
      low = std::max(floor, first_low - pad), high = std::min(top, first_high + pad);
    }
  }
  double mean = 0, sum = 0, n = static_cast<double>(groups);
  for (size_t g = 0; g < groups; ++g) {
    best[g] = Lowest([&](size_t j) { return total[j] - part[g][j]; });
    mean += best[g] / n;
  }
  for (double b : best) sum += (b - mean) * (b - mean);
  // The gate is as wide as the noise of its force.
  double half = Student975(n - 1) * std::sqrt(sum * (n - 1) / n) + soft;
  // Compared with no gate, in the cost of the windows: chosen so that recordings without sticking
  // show none (cut_fit_test).
  fit->threshold_seen = gain > 6;
  if (fit->threshold_seen) {
    fit->threshold_n = {value, std::min(first_low, value - half),
                        std::max(first_high, value + half)};
  } else {
    fit->threshold_n = {floor, std::max(0.0, std::min(floor, fit->coulomb_n.low)),
                        std::max({first_high, fit->coulomb_n.high, floor})};
  }
}

}  // namespace cut
}  // namespace enamel::station::lab
