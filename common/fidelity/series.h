#pragma once

#include <vector>

#include "common/math/vec.h"

// What is asked of forces that are sampled at one rate. Thread safety: pure functions.
namespace enamel::fidelity {

using Series = std::vector<dvec3>;

// a - b, as long as the shorter.
Series Difference(const Series& a, const Series& b);
// RMS of the length of the vectors; 0 of none.
double RmsOf(const Series& v);
double RmsOf(const Series& v, size_t from, size_t to);
// The length that `share` (0 to 1) of the vectors do not exceed; 0 of none.
double WithinOf(const Series& v, double share);
// Mean of each `n` that follow one another; a rest is left out.
Series MeansOf(const Series& v, size_t n);

}  // namespace enamel::fidelity
