#include "station/lab/tissue/cut_solve.h"

#include <algorithm>
#include <array>

namespace enamel::station::lab::cut {
namespace {

dmat3 Outer(const dvec3& a, const dvec3& b) { return dmat3(a * b.x, a * b.y, a * b.z); }

// The symmetric matrix of column `j` of B.
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

// The equations of one window: columns, right side, and the average that noise in V adds to X'X and
// X'y.
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
    // Linear in the compliance only around a known B: `at` is the last round's.
    e.x[n++] = -(Damping(p, at, axis) * fdot);
  }
  // One equation a window: across the motion a scalar model has no information and would only add
  // noise.
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

// Weighted least squares, corrected for speed noise; leaves out the windows in stretch `out` of the
// groups.
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
        // X'X of noisy speeds is too large by their variance, which would make B too small (errors
        // in variables), so it is subtracted.
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
      // Huber's weights; beyond kReject a window shows something else, not only a large error.
      (*weight)[k] = z > kReject ? 0 : z > kHuber ? kHuber / z : 1;
    }
  }
  return l;
}

}  // namespace

Plan PlanOf(CutModel model, bool coulomb, bool compliance, bool along) {
  Plan p;
  p.model = model, p.coulomb = coulomb, p.compliance = compliance, p.along = along;
  p.damping = model == CutModel::kMatrix ? 6 : model == CutModel::kAxialLateral ? 2 : 1;
  return p;
}

dmat3 Damping(const Plan& p, const Column& x, const dvec3& axis) {
  dmat3 b(0);
  for (int j = 0; j < p.damping; ++j) b += x[j] * Basis(p, j, axis);
  return b;
}

Solved SolvePlan(const Recording& r, const Plan& plan, const std::vector<Window>& windows, double c,
                 const Column& at, bool jackknife) {
  Solved s;
  s.plan = plan;
  for (const Window& w : windows) {
    if (w.used) s.used.push_back(&w);
  }
  if (s.used.size() < kMinWindows) return s;
  std::vector<Equations> eq;
  for (const Window* w : s.used) eq.push_back(EquationsOf(r, plan, *w, at));
  size_t groups = std::min(kGroups, s.used.size() / 2);
  std::vector<int> group;
  // Stretches of time, not every twentieth window: neighbours share samples and errors.
  for (size_t k = 0; k < eq.size(); ++k) group.push_back(static_cast<int>(k * groups / eq.size()));
  s.weight.assign(eq.size(), 1);
  s.fit = Robust(eq, &s.weight, group, -1, 12);
  if (!s.fit.ok) return s;
  Square without_c = s.fit.normal;
  // Compliance is the last column. It is judged by its own interval, and must not take the model
  // with it.
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
    // Starting with the weights of the whole: two rounds are enough for the change of one stretch.
    Linear l = Robust(eq, &weight, group, static_cast<int>(g), 2);
    if (l.ok) s.without.push_back(l.x);
  }
  s.ok = s.without.size() >= 3;
  return s;
}

}  // namespace enamel::station::lab::cut
