#include "station/lab/tissue/small_matrix.h"

#include <cmath>
#include <limits>
#include <utility>

namespace enamel::station::lab::cut {

void Eigen(Square m, Column* values, Square* vectors) {
  int n = m.n;
  vectors->n = n;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) vectors->a[i][j] = i == j;
  }
  // Jacobi's rotations (Golub and Van Loan, 8.5): exact for matrices of a few rows, and the same on
  // every machine.
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

double Condition(const Square& m) {
  Square scaled = m;
  for (int i = 0; i < m.n; ++i) {
    for (int j = 0; j < m.n; ++j) {
      // Scaled to a diagonal of ones: otherwise the units of the unknowns would decide.
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
        // Cholesky: a pivot within rounding means a direction that nothing determines.
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

}  // namespace enamel::station::lab::cut
