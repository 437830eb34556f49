#include "station/lab/tissue/cut_windows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "station/lab/tissue/statistics.h"

namespace enamel::station::lab::cut {
namespace {

constexpr double kMinWindow_s = 0.05, kMaxWindow_s = 0.6;
constexpr double kUsualCounts = 3.5;  // encoder counts in a window at a third of the usual speed
constexpr double kMinCounts = 2.5;    // fewer and the window is slow
constexpr double kSpeedNoise = 0.04;  // of the usual speed

Means MeansOf(const Recording& r, double middle, double width, size_t first, size_t last) {
  Means m;
  double sum = 0, odd = 0;
  for (size_t i = first; i < last; ++i) {
    double a = 2 * M_PI * (r.s[i].t_s - middle) / width;
    sum += (1 + std::cos(a)) * r.width_s[i];
    odd += std::sin(a) * r.width_s[i];
    if (i > first) m.gap = m.gap || r.s[i].t_s - r.s[i - 1].t_s > std::max(2.5 * r.dt, width / 8);
  }
  if (!(sum > 0)) return m;
  double span = 0, square = 0;
  dvec3 x0 = r.s[first].x_mm, f0 = r.s[first].f_n, f(0);
  for (size_t i = first; i < last; ++i) {
    double a = 2 * M_PI * (r.s[i].t_s - middle) / width;
    double even = (1 + std::cos(a)) * r.width_s[i] / sum;
    double k = std::sin(a) * r.width_s[i] - odd * even;  // reproduces a constant and a line
    m.v += k * (r.s[i].x_mm - x0);
    m.fdot += k * (r.s[i].f_n - f0);
    f += even * (r.s[i].f_n - f0);
    span += k * (r.s[i].t_s - middle);
    square += k * k;
  }
  if (!(span > 0)) return m;
  m.v /= span;
  m.fdot /= span;
  m.f = f + f0;
  m.noise = square / (span * span);
  m.ok = true;
  return m;
}

// Variance of white noise: third differences of evenly spaced samples, 1 + 9 + 9 + 1 = 20 of it.
// The mean without the largest hundredth.
double WhiteNoise(const Recording& r, bool force, int axis) {
  std::vector<double> squares;
  for (size_t i = 3; i < r.s.size(); ++i) {
    if (r.s[i].run != r.s[i - 3].run || r.s[i].t_s - r.s[i - 3].t_s > 3.5 * r.dt) continue;
    auto At = [&](size_t k) { return force ? r.s[k].f_n[axis] : r.s[k].x_mm[axis]; };
    // Third differences: a motion that is smooth over four samples vanishes in them.
    double d = At(i) - 3 * At(i - 1) + 3 * At(i - 2) - At(i - 3);
    squares.push_back(d * d / 20);
  }
  if (squares.empty()) return 0;
  std::sort(squares.begin(), squares.end());
  size_t n = std::max<size_t>(1, squares.size() - squares.size() / 100);
  double sum = 0;
  for (size_t i = 0; i < n; ++i) sum += squares[i];
  return sum / static_cast<double>(n);
}

// An encoder's count, 0 if most samples differ from the previous one: it is then in the white
// noise.
double CountOf(const Recording& r, int axis) {
  std::vector<double> steps;
  size_t all = 0;
  for (size_t i = 1; i < r.s.size(); ++i) {
    if (r.s[i].run != r.s[i - 1].run) continue;
    ++all;
    double d = std::fabs(r.s[i].x_mm[axis] - r.s[i - 1].x_mm[axis]);
    if (d > 1e-9) steps.push_back(d);
  }
  // The lower quartile: some steps are two counts, none is less than one.
  return steps.empty() || 2 * steps.size() > all ? 0 : Quantile(steps, 0.25);
}

// The shortest window that gives accurate speeds.
double WindowOf(const Recording& r) {
  std::vector<double> speeds;
  size_t per = std::max<size_t>(2, static_cast<size_t>(0.1 / r.dt));
  for (size_t i = per; i < r.s.size(); i += per) {
    if (r.s[i].run == r.s[i - per].run)
      speeds.push_back(glm::length(r.s[i].x_mm - r.s[i - per].x_mm) /
                       (r.s[i].t_s - r.s[i - per].t_s));
  }
  double top = Quantile(speeds, 0.95), sum = 0, n = 0;
  for (double v : speeds) {
    if (v > 0.1 * top && v <= top) sum += v * v, n += 1;
  }
  double usual = n > 0 ? std::sqrt(sum / n) : 0;
  double least = std::max(kMinWindow_s, static_cast<double>(kMinSamples) * r.dt);
  if (!(usual > 0)) return least;
  double noise = std::max({r.noise_mm2.x, r.noise_mm2.y, r.noise_mm2.z});
  double count = std::max({r.count_mm.x, r.count_mm.y, r.count_mm.z});
  // Variance of a speed under the bump: 2 pi^2 noise dt / W^3.
  double by_noise =
      std::cbrt(2 * M_PI * M_PI * noise * r.dt) / std::pow(kSpeedNoise * usual, 2.0 / 3.0);
  double by_count = kUsualCounts * count / (usual / 3);
  return std::clamp(std::max(by_noise, by_count), least, std::max(least, kMaxWindow_s));
}

// Variance that a count adds to a speed of `n` counts in a window. Below one it is 1.5 n - n^2 (an
// occasional step), far above 2/(pi^2 n^4) (the bump's remainder of a saw-tooth). n is itself
// measured: a slow axis shows none or two for a true half count, so the variance is held at its
// largest up to 1.5.
double CountVariance(double speed, double count, double window) {
  if (!(count > 0)) return 0;
  double n = std::fabs(speed) * window / count, unit = count / window;
  double m = 1.5 / std::max(n, 1.5);
  return 0.5 * m * m * m * m * unit * unit;
}

}  // namespace

Recording RecordingOf(std::vector<CutSample> s, double dt_s, bool magnitude) {
  Recording r;
  r.s = std::move(s);
  r.dt = dt_s;
  r.magnitude = magnitude;
  size_t n = r.s.size();
  r.width_s.assign(n, dt_s);
  for (size_t i = 0; i < n; ++i) {
    double before = i > 0 && r.s[i - 1].run == r.s[i].run ? r.s[i].t_s - r.s[i - 1].t_s : dt_s;
    double after = i + 1 < n && r.s[i + 1].run == r.s[i].run ? r.s[i + 1].t_s - r.s[i].t_s : dt_s;
    r.width_s[i] = 0.5 * (before + after);
  }
  for (int k = 0; k < 3; ++k) {
    r.count_mm[k] = CountOf(r, k);
    r.noise_mm2[k] = std::max(WhiteNoise(r, false, k), r.count_mm[k] * r.count_mm[k] / 12);
  }
  for (int k = 0; k < 3; ++k)
    r.force_noise_n = std::max(r.force_noise_n, std::sqrt(WhiteNoise(r, true, k)));
  r.window_s = WindowOf(r);
  return r;
}

size_t DropSpikes(std::vector<CutSample>* s) {
  size_t n = s->size();
  if (n < 9) return 0;
  std::vector<char> bad(n, 0);
  for (int q = 0; q < 6; ++q) {
    auto At = [&](size_t i) { return q < 3 ? (*s)[i].x_mm[q] : (*s)[i].f_n[q - 3]; };
    std::vector<double> off(n, 0), step;
    for (size_t i = 2; i + 2 < n; ++i) {
      std::array<double, 5> five{At(i - 2), At(i - 1), At(i), At(i + 1), At(i + 2)};
      std::nth_element(five.begin(), five.begin() + 2, five.end());
      off[i] = std::fabs(At(i) - five[2]);
      step.push_back(std::fabs(At(i) - At(i - 1)));
    }
    // 1.4826 turns a median into a standard deviation; added are the steps of a fast motion, which
    // are not spikes.
    double limit = 8 * std::max(1.4826 * Quantile(off, 0.5), Quantile(step, 0.95));
    if (!(limit > 0)) {
      for (double d : step) limit = limit == 0 || (d > 0 && 4 * d < limit) ? 4 * d : limit;
    }
    for (size_t i = 2; i + 2 < n; ++i) bad[i] |= limit > 0 && off[i] > limit;
  }
  size_t kept = 0;
  for (size_t i = 0; i < n; ++i) {
    if (!bad[i]) (*s)[kept++] = (*s)[i];
  }
  s->resize(kept);
  return n - kept;
}

std::vector<Window> WindowsOf(const Recording& r, double width) {
  std::vector<Window> out;
  double half = width / 2;
  size_t from = 0;
  while (from < r.s.size()) {
    size_t to = from;
    while (to < r.s.size() && r.s[to].run == r.s[from].run) ++to;
    size_t first = from, last = from;
    double end = r.s[to - 1].t_s + 0.5 * r.dt - half;
    // Half a window on: bumps that overlap by half weigh every sample equally.
    for (double t = r.s[from].t_s - 0.5 * r.dt + half; t <= end; t += half) {
      while (first < to && r.s[first].t_s < t - half) ++first;
      while (last < to && r.s[last].t_s < t + half) ++last;
      if (last - first < kMinSamples / 2) continue;
      Window w;
      w.first = first, w.last = last, w.middle_s = t;
      size_t cut = first, a = first, b = first;
      while (cut < last && r.s[cut].t_s < t) ++cut;
      a = first, b = last;
      w.whole = MeansOf(r, t, width, a, b);
      w.early = MeansOf(r, t - half / 2, half, a, cut);
      w.late = MeansOf(r, t + half / 2, half, cut, b);
      // Rows missing at an edge cut off the bump's foot.
      w.whole.gap = w.whole.gap || r.s[first].t_s - (t - half) > std::max(2.5 * r.dt, half / 4) ||
                    t + half - r.s[last - 1].t_s > std::max(2.5 * r.dt, half / 4);
      if (!w.whole.ok) continue;
      for (size_t i = first; i < last; ++i) w.axis += r.s[i].axis;
      for (int k = 0; k < 3; ++k)
        w.variance[k] = std::max(r.noise_mm2[k] * w.whole.noise,
                                 CountVariance(w.whole.v[k], r.count_mm[k], width));
      out.push_back(w);
    }
    from = to;
  }
  return out;
}

dvec3 Front(const Recording& r, const Means& m, double c) {
  if (c == 0) return m.v;
  if (!r.magnitude) return m.v - c * m.fdot;
  double speed = glm::length(m.v);
  return speed > 0 ? m.v * ((speed - c * m.fdot.x) / speed) : m.v;
}

double Along(const Recording& r, const Window& w) {
  return r.magnitude ? w.whole.f.x : Dot(w.whole.f, w.u);
}

void Classify(const Recording& r, double c, double threshold, std::vector<Window>* windows,
              CutFit* fit) {
  fit->windows = {};
  std::vector<double> speeds;
  for (Window& w : *windows) {
    w.v = Front(r, w.whole, c);
    double speed = glm::length(w.v);
    w.u = speed > 0 ? w.v / speed : dvec3(0);
    w.used = false, w.steady = !w.whole.gap;
    double along = r.magnitude ? w.whole.f.x : glm::length(w.whole.f);
    if (!w.whole.gap && along > kContact_n) speeds.push_back(speed);
  }
  double top = Quantile(speeds, 0.98);
  std::vector<double> forces;
  for (const Window& w : *windows) {
    if (!w.whole.gap && glm::length(w.v) > 0.05 * top) forces.push_back(Along(r, w));
  }
  fit->force_max_n = std::max(0.0, Quantile(forces, 0.98));
  double touch = std::max(kContact_n, 0.02 * fit->force_max_n);
  auto Slow = [&](const Window& w) {
    double sigma = std::sqrt(w.variance.x + w.variance.y + w.variance.z);
    double count = std::max({r.count_mm.x, r.count_mm.y, r.count_mm.z});
    return glm::length(w.v) <
           std::max({0.05 * top, 5 * sigma, kMinCounts * count / r.window_s, 1e-3});
  };
  std::vector<char> air(windows->size(), 0);
  for (size_t i = 0; i < windows->size(); ++i) {
    const Window& w = (*windows)[i];
    if (w.whole.gap || Slow(w) || std::fabs(Along(r, w)) >= touch) continue;
    // The adjacent windows too: the bur is partly out there.
    for (size_t k = i > 0 ? i - 1 : 0; k < std::min(windows->size(), i + 2); ++k) air[k] = 1;
  }
  fit->speed_max_mm_s = 0;
  double turn = 0;
  for (size_t i = 0; i < windows->size(); ++i) {
    Window& w = (*windows)[i];
    w.steady = w.steady && !air[i];
    if (w.whole.gap) {
      ++fit->windows.gap;
    } else if (air[i]) {
      ++fit->windows.air;
    } else if (Slow(w)) {
      ++fit->windows.slow;
    } else {
      double speed = glm::length(w.v), least = 1;
      dvec3 sum(0);
      for (const Means* m : {&w.early, &w.late}) {
        dvec3 v = m->ok ? Front(r, *m, c) : dvec3(0);
        double s = glm::length(v), along = Dot(v, w.u);
        least = std::min(least, std::min(along / (0.3 * speed), s > 0 ? 2 * along / s : 0));
        if (s > 0) sum += v / s;
      }
      bool stuck = false;
      if (threshold > 0) {
        size_t below = 0;
        for (size_t k = w.first; k < w.last; ++k) below += r.smooth_n[k] < threshold;
        // More than a fiftieth of its samples.
        stuck = 50 * below > w.last - w.first;
      }
      if (stuck) {
        ++fit->windows.slow;
      } else if (least < 1 || Along(r, w) <= 0) {
        ++fit->windows.turning;
      } else {
        w.used = true;
        turn += 1 - glm::length(sum) / 2;
        ++fit->windows.used;
        fit->speed_max_mm_s = std::max(fit->speed_max_mm_s, speed);
      }
    }
  }
  fit->turn_bias = fit->windows.used > 0 ? turn / static_cast<double>(fit->windows.used) : 0;
}

void SmoothForce(Recording* r) {
  size_t n = r->s.size();
  r->smooth_n.assign(n, 0);
  r->smooth.assign(n, dvec3(0));
  size_t a = 0, b = 0;
  dvec3 sum(0);
  for (size_t i = 0; i < n; ++i) {
    double t = r->s[i].t_s;
    // A running sum: each sample enters once and leaves once.
    while (b < n && r->s[b].t_s <= t + kForceSmooth_s && r->s[b].run == r->s[i].run)
      sum += r->s[b++].f_n;
    while (a < i && (r->s[a].t_s < t - kForceSmooth_s || r->s[a].run != r->s[i].run))
      sum -= r->s[a++].f_n;
    dvec3 mean = sum / static_cast<double>(b - a);
    r->smooth[i] = mean;
    r->smooth_n[i] = r->magnitude ? mean.x : glm::length(mean);
  }
}

}  // namespace enamel::station::lab::cut
