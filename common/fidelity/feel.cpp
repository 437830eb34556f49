#include "common/fidelity/feel.h"

#include <cmath>

namespace enamel::fidelity {

double FeltIn(const FeltDevice& device, const FeltTrial& trial, double grip,
              std::span<const std::vector<dvec3>> ways) {
  FeltTrial in_grip = trial;
  in_grip.hand.stiffness_n_per_m = grip;
  in_grip.ideal = false;
  double error2 = 0, ideal2 = 0;
  for (const std::vector<dvec3>& way : ways) {
    const FeltFigures f = Feel(device, in_grip, way);
    error2 += f.felt_error_rms_n * f.felt_error_rms_n;
    ideal2 += f.tool_rms_n * f.tool_rms_n;
  }
  return std::sqrt(error2 / ideal2);
}

double StiffestGrip(std::span<const double> grips, std::span<const double> errors, double share) {
  if (errors.empty() || errors[0] > share) return 0;
  for (size_t i = 1; i < errors.size(); ++i) {
    if (errors[i] <= share) continue;
    const double part = (share - errors[i - 1]) / (errors[i] - errors[i - 1]);
    return grips[i - 1] * std::pow(grips[i] / grips[i - 1], part);
  }
  return grips.back();
}

}  // namespace enamel::fidelity
