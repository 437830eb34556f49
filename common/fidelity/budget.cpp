#include "common/fidelity/budget.h"

#include <algorithm>
#include <iterator>

#include "common/base/check.h"
#include "common/fidelity/series.h"

namespace enamel::fidelity {
namespace {

constexpr int kFiner = 8;
// Of a cell: so little changes no force by a micronewton.
constexpr double kExact = 1e-6;

Series FineMaxwell(FeltDevice d, FeltTrial trial, const std::vector<dvec3>& way) {
  trial.law = haptics::LawKind::kMaxwell;
  d.tick_s /= kFiner;
  return MeansOf(ForceInHand(d, trial, way, false), kFiner);
}

}  // namespace

FeltBudget BudgetOf(const FeltDevice& d, const FeltTrial& asked, const std::vector<dvec3>& way) {
  ENAMEL_CHECK(d.board.ticks == 0);
  FeltTrial trial = asked;
  trial.hand = SameHand(asked.hand, d.mass_kg);
  FeltTrial at_once = trial;
  at_once.delay_ticks = 0;
  FeltTrial plain = at_once;
  plain.lattice = {};
  FeltDevice device = ToolOf(d);
  std::vector<Series> forces;
  auto add_damped = [&] { forces.push_back(ForceInHand(device, plain, way, true)); };
  add_damped();
  device.peak_force_n = d.peak_force_n;
  add_damped();
  device.mass_kg = d.mass_kg;
  add_damped();
  device.damping_n_s_per_m = d.damping_n_s_per_m;
  add_damped();
  device.friction_n = d.friction_n;
  add_damped();
  device.resolution_m = d.resolution_m * kExact;
  forces.push_back(FineMaxwell(device, plain, way));
  forces.push_back(ForceInHand(device, plain, way, false));
  forces.push_back(ForceInHand(d, at_once, way, false));
  forces.push_back(ForceInHand(d, trial, way, false));

  const auto from = static_cast<size_t>(trial.from_s / d.tick_s);
  size_t n = forces[0].size();
  for (const Series& one : forces) n = std::min(n, one.size());
  for (Series& one : forces)
    one = Series(one.begin() + static_cast<long>(from), one.begin() + static_cast<long>(n));
  const Series error = Difference(forces.back(), forces.front());
  FeltBudget out;
  out.rms_n = RmsOf(error);
  out.p95_n = WithinOf(error, 0.95);
  out.tool_rms_n = RmsOf(forces.front());
  constexpr const char* kCauses[] = {"saturation", "inertia", "damping",      "friction",
                                     "lag",        "law",     "quantisation", "delay"};
  for (size_t i = 0; i < std::size(kCauses); ++i) {
    const Series step = Difference(forces[i + 1], forces[i]);
    double along = 0, whole = 0;
    for (size_t k = 0; k < step.size(); ++k) {
      along += Dot(step[k], error[k]);
      whole += Dot(error[k], error[k]);
    }
    out.parts.push_back(
        {kCauses[i], RmsOf(step), WithinOf(step, 0.95), whole > 0 ? along / whole : 0});
  }
  return out;
}

}  // namespace enamel::fidelity
