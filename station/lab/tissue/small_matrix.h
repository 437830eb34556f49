#pragma once

#include <array>

// Symmetric matrices of a few rows, as the normal equations of a fit are. Pure functions, any
// thread.
namespace enamel::station::lab::cut {

constexpr int kMost = 8;  // unknowns: 6 of B, Fc, c

// The first `n` rows and columns count.
struct Square {
  int n = 0;
  std::array<std::array<double, kMost>, kMost> a{};
};
using Column = std::array<double, kMost>;

// Jacobi rotations: eigenvalues ascending, eigenvectors as columns.
void Eigen(Square m, Column* values, Square* vectors);

// Of the matrix scaled to a unit diagonal; infinite where it is not positive definite.
double Condition(const Square& m);

// m x = y by Cholesky's factors. False where `m` is not positive definite.
bool Solve(const Square& m, const Column& y, Column* x);

}  // namespace enamel::station::lab::cut
