#include "station/qualify/cut_fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace enamel::station::qualify {
namespace {

constexpr double kLeastWindow_s = 0.05, kMostWindow_s = 0.6;
constexpr size_t kLeastSamples = 8, kLeastWindows = 8;
constexpr double kUsualCounts = 3.5;  // encoder counts in a window at a third of the usual speed
constexpr double kLeastCounts = 2.5;  // fewer and the window is slow
constexpr double kSpeedNoise = 0.04;  // of the usual speed
constexpr double kContact_n = 0.02;
constexpr double kMostCondition = 400;
constexpr size_t kGroups = 20;
constexpr double kHuber = 2, kReject = 8;  // in medians of the residual
constexpr double kMostCompliance_mm_per_n = 1;
constexpr double kForceSmooth_s = 0.01;  // half width of the force the gate sees
constexpr size_t kGrid = 80;
constexpr int kMost = 8;  // unknowns: 6 of B, Fc, c

std::string F(double v, const char* format = "%.3g") {
  char text[64];
  std::snprintf(text, sizeof text, format, v);
  return text;
}

double Quantile(std::vector<double> v, double q) {
  if (v.empty()) return 0;
  auto at = v.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(v.size() - 1) + 0.5);
  std::nth_element(v.begin(), at, v.end());
  return *at;
}

// Two-sided 97.5 % point of Student's t (Hill 1970's expansion about the normal; below 1 % off from
// 3 degrees of freedom).
double Student975(double n) {
  constexpr double z = 1.959964;
  double z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
  return z + (z3 + z) / (4 * n) + (5 * z5 + 16 * z3 + 3 * z) / (96 * n * n) +
         (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * n * n * n);
}

// Symmetric matrices of up to kMost rows.
struct Square {
  int n = 0;
  std::array<std::array<double, kMost>, kMost> a{};
};
using Column = std::array<double, kMost>;

// Jacobi rotations: eigenvalues ascending, eigenvectors as columns.
void Eigen(Square m, Column* values, Square* vectors) {
  int n = m.n;
  vectors->n = n;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) vectors->a[i][j] = i == j;
  }
  for (int sweep = 0; sweep < 60; ++sweep) {
    double off = 0, on = 0;
    for (int i = 0; i < n; ++i) {
      on += m.a[i][i] * m.a[i][i];
      for (int j = 0; j < i; ++j) off += m.a[i][j] * m.a[i][j];
    }
    if (off <= 1e-28 * on) break;
    for (int p = 0; p < n; ++p) {
      for (int q = p + 1; q < n; ++q) {
        if (m.a[p][q] == 0) continue;
        double theta = (m.a[q][q] - m.a[p][p]) / (2 * m.a[p][q]);
        double t = (theta < 0 ? -1 : 1) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
        double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < n; ++k) {
          double kp = m.a[k][p], kq = m.a[k][q];
          m.a[k][p] = c * kp - s * kq, m.a[k][q] = s * kp + c * kq;
        }
        for (int k = 0; k < n; ++k) {
          double pk = m.a[p][k], qk = m.a[q][k];
          m.a[p][k] = c * pk - s * qk, m.a[q][k] = s * pk + c * qk;
          double vp = vectors->a[k][p], vq = vectors->a[k][q];
          vectors->a[k][p] = c * vp - s * vq, vectors->a[k][q] = s * vp + c * vq;
        }
      }
    }
  }
  std::array<int, kMost> order{};
  for (int i = 0; i < n; ++i) order[i] = i;
  for (int i = 1; i < n; ++i) {
    for (int j = i; j > 0 && m.a[order[j]][order[j]] < m.a[order[j - 1]][order[j - 1]]; --j)
      std::swap(order[j], order[j - 1]);
  }
  Square unsorted = *vectors;
  for (int j = 0; j < n; ++j) {
    (*values)[j] = m.a[order[j]][order[j]];
    for (int i = 0; i < n; ++i) vectors->a[i][j] = unsorted.a[i][order[j]];
  }
}

// Of the matrix scaled to a unit diagonal; infinite where it is not positive definite.
double Condition(const Square& m) {
  Square scaled = m;
  for (int i = 0; i < m.n; ++i) {
    for (int j = 0; j < m.n; ++j) {
      double d = m.a[i][i] * m.a[j][j];
      if (!(m.a[i][i] > 0) || !(d > 0)) return std::numeric_limits<double>::infinity();
      scaled.a[i][j] = m.a[i][j] / std::sqrt(d);
    }
  }
  Column values{};
  Square vectors;
  Eigen(scaled, &values, &vectors);
  return values[0] > 1e-12 ? values[m.n - 1] / values[0] : std::numeric_limits<double>::infinity();
}

bool Solve(const Square& m, const Column& y, Column* x) {
  int n = m.n;
  Square l;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = m.a[i][j];
      for (int k = 0; k < j; ++k) sum -= l.a[i][k] * l.a[j][k];
      if (i == j) {
        if (!(sum > 1e-14 * m.a[i][i])) return false;
        l.a[i][i] = std::sqrt(sum);
      } else {
        l.a[i][j] = sum / l.a[j][j];
      }
    }
  }
  for (int i = 0; i < n; ++i) {
    double sum = y[i];
    for (int k = 0; k < i; ++k) sum -= l.a[i][k] * (*x)[k];
    (*x)[i] = sum / l.a[i][i];
  }
  for (int i = n - 1; i >= 0; --i) {
    double sum = (*x)[i];
    for (int k = i + 1; k < n; ++k) sum -= l.a[k][i] * (*x)[k];
    (*x)[i] = sum / l.a[i][i];
  }
  return true;
}

// Means under one bump: speed, force and the force's rate.
struct Means {
  dvec3 v{0}, f{0}, fdot{0};
  double noise = 0;  // variance of v per axis for white noise of variance 1 in position
  bool ok = false, gap = false;
};

struct Window {
  Means whole, early, late;
  dvec3 axis{0}, variance{0};  // of whole.v, per axis
  size_t first = 0, last = 0;  // samples
  double middle_s = 0;
  // By Classify.
  dvec3 v{0}, u{0};  // of the front
  bool used = false, steady = false;
  double weight = 1;
};

struct Recording {
  std::vector<CutSample> s;
  std::vector<dvec3> smooth;     // F as the gate sees it
  std::vector<double> smooth_n;  // its size
  std::vector<double> width_s;   // of each sample's trapezium
  double dt = 0, window_s = 0;
  dvec3 noise_mm2{0}, count_mm{0};
  double force_noise_n = 0;
  bool magnitude = false;
};

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

// Drops single samples that stand out of the median of five about them.
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

// Variance of white noise: third differences of evenly spaced samples, 1 + 9 + 9 + 1 = 20 of it.
// The mean without the largest hundredth.
double WhiteNoise(const Recording& r, bool force, int axis) {
  std::vector<double> squares;
  for (size_t i = 3; i < r.s.size(); ++i) {
    if (r.s[i].run != r.s[i - 3].run || r.s[i].t_s - r.s[i - 3].t_s > 3.5 * r.dt) continue;
    auto At = [&](size_t k) { return force ? r.s[k].f_n[axis] : r.s[k].x_mm[axis]; };
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

// An encoder's count, 0 where most samples differ from the one before: then it is in the white
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
  return steps.empty() || 2 * steps.size() > all ? 0 : Quantile(steps, 0.25);
}

// The shortest window in which speeds are known well enough.
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
  double least = std::max(kLeastWindow_s, static_cast<double>(kLeastSamples) * r.dt);
  if (!(usual > 0)) return least;
  double noise = std::max({r.noise_mm2.x, r.noise_mm2.y, r.noise_mm2.z});
  double count = std::max({r.count_mm.x, r.count_mm.y, r.count_mm.z});
  // Variance of a speed under the bump: 2 pi^2 noise dt / W^3.
  double by_noise =
      std::cbrt(2 * M_PI * M_PI * noise * r.dt) / std::pow(kSpeedNoise * usual, 2.0 / 3.0);
  double by_count = kUsualCounts * count / (usual / 3);
  return std::clamp(std::max(by_noise, by_count), least, std::max(least, kMostWindow_s));
}

// Variance a count adds to a speed of `n` counts in a window. Below one it is 1.5 n - n^2 (a step
// now and then), far above 2/(pi^2 n^4) (what the bump leaves of a saw-tooth). n is itself the
// measured one: a slow axis shows none or two where half a count is true, so that the variance is
// held at its largest up to 1.5.
double CountVariance(double speed, double count, double window) {
  if (!(count > 0)) return 0;
  double n = std::fabs(speed) * window / count, unit = count / window;
  double m = 1.5 / std::max(n, 1.5);
  return 0.5 * m * m * m * m * unit * unit;
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
    for (double t = r.s[from].t_s - 0.5 * r.dt + half; t <= end; t += half) {
      while (first < to && r.s[first].t_s < t - half) ++first;
      while (last < to && r.s[last].t_s < t + half) ++last;
      if (last - first < kLeastSamples / 2) continue;
      Window w;
      w.first = first, w.last = last, w.middle_s = t;
      size_t cut = first, a = first, b = first;
      while (cut < last && r.s[cut].t_s < t) ++cut;
      a = first, b = last;
      w.whole = MeansOf(r, t, width, a, b);
      w.early = MeansOf(r, t - half / 2, half, a, cut);
      w.late = MeansOf(r, t + half / 2, half, cut, b);
      // Rows missing at an edge leave the bump without its foot.
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

// The front's speed from the tip's. A magnitude's rate is taken along the motion.
dvec3 Front(const Recording& r, const Means& m, double c) {
  if (c == 0) return m.v;
  if (!r.magnitude) return m.v - c * m.fdot;
  double speed = glm::length(m.v);
  return speed > 0 ? m.v * ((speed - c * m.fdot.x) / speed) : m.v;
}

double Along(const Recording& r, const Window& w) {
  return r.magnitude ? w.whole.f.x : Dot(w.whole.f, w.u);
}

// Sorts the windows; those of `gated` force (threshold seen) must keep it above.
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
           std::max({0.05 * top, 5 * sigma, kLeastCounts * count / r.window_s, 1e-3});
  };
  std::vector<char> air(windows->size(), 0);
  for (size_t i = 0; i < windows->size(); ++i) {
    const Window& w = (*windows)[i];
    if (w.whole.gap || Slow(w) || std::fabs(Along(r, w)) >= touch) continue;
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

struct Plan {
  CutModel model = CutModel::kScalar;
  bool coulomb = true, compliance = false;
  bool along = false;  // one equation a window, along the motion
  int damping = 1;     // columns of B
  int columns() const { return damping + coulomb + compliance; }
};

Plan PlanOf(CutModel model, bool coulomb, bool compliance, bool along) {
  Plan p;
  p.model = model, p.coulomb = coulomb, p.compliance = compliance, p.along = along;
  p.damping = model == CutModel::kMatrix ? 6 : model == CutModel::kAxialLateral ? 2 : 1;
  return p;
}

dmat3 Outer(const dvec3& a, const dvec3& b) { return dmat3(a * b.x, a * b.y, a * b.z); }

// The symmetric matrix column `j` of B stands for.
dmat3 Basis(const Plan& p, int j, const dvec3& axis) {
  if (p.model == CutModel::kScalar) return dmat3(1);
  if (p.model == CutModel::kAxialLateral) {
    dmat3 along = Outer(axis, axis);
    return j == 1 ? along : dmat3(1) - along;
  }
  constexpr int kRow[] = {0, 1, 2, 0, 0, 1}, kColumn[] = {0, 1, 2, 1, 2, 2};
  dmat3 m(0);
  m[kRow[j]][kColumn[j]] = m[kColumn[j]][kRow[j]] = 1;
  return m;
}

dmat3 Damping(const Plan& p, const Column& x, const dvec3& axis) {
  dmat3 b(0);
  for (int j = 0; j < p.damping; ++j) b += x[j] * Basis(p, j, axis);
  return b;
}

// The equations of one window: columns, right side, and what noise in V adds on average to X'X and
// to X'y.
struct Equations {
  std::array<dvec3, kMost> x{};
  dvec3 y{0};
  Square noise;
  Column noise_y{};
};

Equations EquationsOf(const Recording& r, const Plan& p, const Window& w, const Column& at) {
  Equations e;
  dvec3 axis = glm::length(w.axis) > 0 ? glm::normalize(w.axis) : dvec3(0, 0, 1);
  std::array<dmat3, 6> basis{};
  dvec3 y = r.magnitude ? w.whole.f.x * w.u : w.whole.f;
  for (int j = 0; j < p.damping; ++j) {
    basis[j] = Basis(p, j, axis);
    e.x[j] = basis[j] * w.v;
  }
  int n = p.damping;
  if (p.coulomb) e.x[n++] = w.u;
  if (p.compliance) {
    dvec3 fdot = r.magnitude ? w.whole.fdot.x * w.u : w.whole.fdot;
    e.x[n++] = -(Damping(p, at, axis) * fdot);
  }
  if (p.along) {
    for (int j = 0; j < n; ++j) e.x[j] = dvec3(Dot(e.x[j], w.u), 0, 0);
    y = dvec3(Dot(y, w.u), 0, 0);
  }
  e.y = y;
  e.noise.n = n;
  for (int i = 0; i < p.damping; ++i) {
    for (int j = 0; j < p.damping; ++j) {
      double sum = 0;
      if (p.along && p.model != CutModel::kScalar) {
        sum = Dot(basis[i] * w.u, w.variance * (basis[j] * w.u));
      } else {
        for (int k = 0; k < 3; ++k) sum += w.variance[k] * Dot(basis[i][k], basis[j][k]);
      }
      e.noise.a[i][j] = sum;
    }
  }
  if (!p.coulomb) return e;
  // The direction u is computed from the same V. To second order, with S the variance of V and
  // P = I - u u': E[u] is off by -(u tr(P S)/2 + P S u)/|V|^2, E[u E_j V] by tr(P E_j S)/|V| more.
  double speed = glm::length(w.v);
  dvec3 su = w.variance * w.u;
  double across = w.variance.x + w.variance.y + w.variance.z - Dot(w.u, su);
  dvec3 off = -(0.5 * across * w.u + su - Dot(su, w.u) * w.u) / (speed * speed);
  int at_u = p.damping;
  for (int j = 0; j < n; ++j) {
    if (j == at_u) continue;
    double sum = 0;
    if (j < p.damping) {
      sum = Dot(off, basis[j] * w.v);
      dvec3 pu = basis[j] * w.u;  // tr(P E S) = tr(E S) - u'E S u
      for (int k = 0; k < 3; ++k) sum += basis[j][k][k] * w.variance[k] / speed;
      sum -= Dot(pu, su) / speed;
    } else if (!p.along) {
      sum = Dot(off, e.x[j]);
    }
    e.noise.a[at_u][j] = e.noise.a[j][at_u] = sum;
  }
  if (r.magnitude) {
    e.noise_y[0] = 0.5 * across / speed * w.whole.f.x;
  } else {
    e.noise_y[at_u] = Dot(off, w.whole.f);
  }
  return e;
}

struct Linear {
  Column x{};
  Square normal;
  double median = 0;  // of the residual's size
  bool ok = false;
};

// Weighted least squares with the speed noise taken out; windows in stretch `out` of
// the groups are left out.
Linear Least(const std::vector<Equations>& eq, const std::vector<double>& weight,
             const std::vector<int>& group, int out) {
  Linear l;
  int n = eq.front().noise.n;
  l.normal.n = n;
  Column y{};
  for (size_t k = 0; k < eq.size(); ++k) {
    if (group[k] == out || weight[k] == 0) continue;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j)
        l.normal.a[i][j] += weight[k] * (Dot(eq[k].x[i], eq[k].x[j]) - eq[k].noise.a[i][j]);
      y[i] += weight[k] * (Dot(eq[k].x[i], eq[k].y) - eq[k].noise_y[i]);
    }
  }
  l.ok = Solve(l.normal, y, &l.x);
  return l;
}

double Residual(const Equations& e, const Column& x) {
  dvec3 r = e.y;
  for (int j = 0; j < e.noise.n; ++j) r -= x[j] * e.x[j];
  return glm::length(r);
}

// Huber's weights by iteration; `weight` is in and out.
Linear Robust(const std::vector<Equations>& eq, std::vector<double>* weight,
              const std::vector<int>& group, int out, int rounds) {
  Linear l;
  for (int round = 0; round <= rounds; ++round) {
    l = Least(eq, *weight, group, out);
    if (!l.ok) return l;
    std::vector<double> size(eq.size());
    for (size_t k = 0; k < eq.size(); ++k) size[k] = Residual(eq[k], l.x);
    l.median = Quantile(size, 0.5);
    if (round == rounds) break;
    for (size_t k = 0; k < eq.size(); ++k) {
      double z = l.median > 0 ? size[k] / l.median : 0;
      (*weight)[k] = z > kReject ? 0 : z > kHuber ? kHuber / z : 1;
    }
  }
  return l;
}

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

Solved SolvePlan(const Recording& r, const Plan& plan, const std::vector<Window>& windows, double c,
                 const Column& at, bool jackknife) {
  Solved s;
  s.plan = plan;
  for (const Window& w : windows) {
    if (w.used) s.used.push_back(&w);
  }
  if (s.used.size() < kLeastWindows) return s;
  std::vector<Equations> eq;
  for (const Window* w : s.used) eq.push_back(EquationsOf(r, plan, *w, at));
  size_t groups = std::min(kGroups, s.used.size() / 2);
  std::vector<int> group;
  for (size_t k = 0; k < eq.size(); ++k) group.push_back(static_cast<int>(k * groups / eq.size()));
  s.weight.assign(eq.size(), 1);
  s.fit = Robust(eq, &s.weight, group, -1, 12);
  if (!s.fit.ok) return s;
  Square without_c = s.fit.normal;
  without_c.n -= plan.compliance;
  s.condition = Condition(without_c);
  double sum = 0, n = 0;
  for (size_t k = 0; k < eq.size(); ++k) {
    s.outliers += s.weight[k] == 0;
    if (s.weight[k] == 0) continue;
    double size = Residual(eq[k], s.fit.x);
    sum += size * size, n += 1;
  }
  s.residual = std::sqrt(sum / std::max(1.0, n - plan.columns()));
  double noise = 0, all = 0;
  for (size_t k = 0; k < eq.size(); ++k) {
    const Window& w = *s.used[k];
    noise += s.weight[k] * (w.variance.x + w.variance.y + w.variance.z);
    all += s.weight[k] * Dot(w.v, w.v);
    s.speed += glm::length(w.v) / static_cast<double>(eq.size());
  }
  s.attenuation = noise / all;
  s.compliance = c + (plan.compliance ? s.fit.x[plan.columns() - 1] : 0);
  s.ok = true;
  if (!jackknife) return s;
  for (size_t g = 0; g < groups; ++g) {
    std::vector<double> weight = s.weight;
    Linear l = Robust(eq, &weight, group, static_cast<int>(g), 2);
    if (l.ok) s.without.push_back(l.x);
  }
  s.ok = s.without.size() >= 3;
  return s;
}

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

void SmoothForce(Recording* r) {
  size_t n = r->s.size();
  r->smooth_n.assign(n, 0);
  r->smooth.assign(n, dvec3(0));
  size_t a = 0, b = 0;
  dvec3 sum(0);
  for (size_t i = 0; i < n; ++i) {
    double t = r->s[i].t_s;
    while (b < n && r->s[b].t_s <= t + kForceSmooth_s && r->s[b].run == r->s[i].run)
      sum += r->s[b++].f_n;
    while (a < i && (r->s[a].t_s < t - kForceSmooth_s || r->s[a].run != r->s[i].run))
      sum -= r->s[a++].f_n;
    dvec3 mean = sum / static_cast<double>(b - a);
    r->smooth[i] = mean;
    r->smooth_n[i] = r->magnitude ? mean.x : glm::length(mean);
  }
}

// Fth: where the gate makes the motion computed from the force come nearest to what was measured.
// `longer`: windows of `width`, long enough for the few counts of slow motion; a magnitude has no
// direction to add up over turns and takes the windows B was fitted from.
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
  if (all.size() < kLeastWindows || !(top > floor)) return;
  double soft =
      std::max(r.force_noise_n / std::sqrt(std::max(1.0, 2 * kForceSmooth_s / r.dt)), 1e-3 * top);
  std::vector<std::vector<double>> bump(all.size());
  std::vector<dvec3> seen(all.size()), ungated(all.size());
  std::vector<double> weakest(all.size(), 1e300), hardest(all.size(), 0);
  auto Miss = [&](size_t k, double gate) {
    const Window& w = *all[k];
    dvec3 sum(0);
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
  // A window's noise: what half of them miss without any gate, and the resolution's of its own.
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
      if (l + h > 0) x += 0.5 * step * (l - h) / (l + h);
    }
    return x;
  };
  double gain = 0, value = floor, first_low = floor, first_high = floor;
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
    // What is not worse by 4 (twice 1.92: windows overlap) is as good.
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
  // The gate is as wide as the noise of the force it sees.
  double half = Student975(n - 1) * std::sqrt(sum * (n - 1) / n) + soft;
  fit->threshold_seen = gain > 6;
  if (fit->threshold_seen) {
    fit->threshold_n = {value, std::min(first_low, value - half),
                        std::max(first_high, value + half)};
  } else {
    fit->threshold_n = {floor, std::max(0.0, std::min(floor, fit->coulomb_n.low)),
                        std::max({first_high, fit->coulomb_n.high, floor})};
  }
}

}  // namespace

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
      if (!(s > low && s < high)) s = 0.5 * (low + high);
    }
  }
  dvec3 v = At(s);
  return v.x * basis[0] + v.y * basis[1] + v.z * basis[2];
}

CutFit FitCut(const std::vector<CutSample>& samples, double dt_s, bool magnitude, int positions) {
  CutFit fit;
  fit.samples = samples.size();
  Recording r;
  r.s = samples;
  r.dt = dt_s;
  r.magnitude = magnitude;
  if (magnitude) {
    for (CutSample& s : r.s) s.f_n = dvec3(std::fabs(s.f_n.x), 0, 0);
  }
  fit.spikes = DropSpikes(&r.s);
  size_t n = r.s.size();
  if (n < kLeastSamples) {
    fit.refused = "only " + std::to_string(n) + " samples; at least " +
                  std::to_string(kLeastSamples) + " are needed";
    return fit;
  }
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
  r.window_s = fit.window_s = WindowOf(r);
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
  if (!magnitude && power < 0) {
    for (CutSample& s : r.s) s.f_n = -s.f_n;
    windows = WindowsOf(r, r.window_s);
    fit.warnings.push_back("force points against the motion: taken as the tooth's, and turned");
  }
  SmoothForce(&r);

  bool has_axis = std::all_of(r.s.begin(), r.s.end(),
                              [](const CutSample& s) { return glm::length(s.axis) > 0; });
  std::vector<Plan> ladder;
  if (positions == 3 && has_axis)
    ladder.push_back(PlanOf(CutModel::kAxialLateral, true, false, magnitude));
  else if (positions == 3)
    ladder.push_back(PlanOf(CutModel::kMatrix, true, false, magnitude));
  ladder.push_back(PlanOf(CutModel::kScalar, true, false, true));
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
  // What the tip's bending and the threshold hide from the first pass is put right in the next.
  double width = magnitude ? r.window_s : std::max(r.window_s, std::min(4 * r.window_s, 0.8));
  std::vector<Window> longer = WindowsOf(r, width);
  bool bends = true;
  double bend_sure = 0;
  for (int round = 0; round < 6; ++round) {
    double c_before = c, threshold_before = threshold;
    Classify(r, c, threshold, &windows, &fit);
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
        // Three standard errors: a bend that is not there only adds noise.
        bend_sure = (e.value - e.low) * 1.5;
        if (e.value < bend_sure) {
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
  if (fit.b.high <= 0)
    fit.refused = "force falls with speed (B = " + F(fit.b.value, "%.3f") +
                  " N s/mm): position and force do not belong together, or not in this unit";
  return fit;
}

}  // namespace enamel::station::qualify
