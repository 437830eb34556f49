#pragma once

#include <vector>

// Order statistics and Student's t. Pure functions, any thread.
namespace enamel::station::lab::cut {

// The q-quantile (0 to 1), the nearest member; 0 of nothing.
double Quantile(std::vector<double> v, double q);

// Two-sided 97.5 % point of Student's t for `n` degrees of freedom (Hill 1970's expansion about the
// normal; below 1 % off from 3 degrees of freedom).
double Student975(double n);

}  // namespace enamel::station::lab::cut
