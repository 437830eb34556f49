#include <algorithm>

#include "station/lab/suites/adversary.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {

haptics::TipCell GameRules::Cell(double delta) const {
  if (!lattice) return haptics::CartesianCell(dvec3(delta), noise_counts);
  return haptics::LatticeCell(delta, driver_rounds ? delta : 0, noise_counts);
}

std::string GameRules::Name() const {
  std::string name = "delay " + std::to_string(delay_ticks);
  if (undeclared_ticks > 0) name += " and " + std::to_string(undeclared_ticks) + " undeclared";
  if (noise_counts > 0) name += ", noise " + std::to_string(noise_counts);
  if (lattice) name += driver_rounds ? ", turned lattice rounded again" : ", turned lattice";
  if (bounds) name += ", bounds jump";
  if (gaps) name += ", gaps";
  if (late == Late::kCovered) name += ", late ticks (clause of one more)";
  if (late == Late::kLeak) name += ", lost ticks (leak)";
  return name;
}

double ClauseStiffness(const DeviceModel& m, const GameRules& rules) {
  double ticks = rules.clause_ticks() + 1;
  // Kc <= 2 b/((d + 1)^2 T), the clause of README.md.
  return std::min(m.kc_n_per_m, 2 * m.damping_n_s_per_m / (ticks * ticks * m.tick_s()));
}

bool Covered(std::optional<haptics::LawKind> law, const GameRules& rules) {
  // The theorem does not cover undeclared delay.
  if (rules.undeclared_ticks > 0) return false;
  return !law || ProvedLaw(*law);
}

std::vector<GameRules> AllRules() {
  using Late = GameRules::Late;
  std::vector<GameRules> all;
  for (int delay = 0; delay <= 4; ++delay) {
    all.push_back({.delay_ticks = delay});
    all.push_back({.delay_ticks = delay, .noise_counts = 1});
    all.push_back({.delay_ticks = delay, .lattice = true, .driver_rounds = delay % 2 == 0});
    all.push_back({.delay_ticks = delay, .gaps = true});
    all.push_back({.delay_ticks = delay, .late = Late::kCovered});
    all.push_back({.delay_ticks = delay,
                   .noise_counts = 2,
                   .lattice = true,
                   .driver_rounds = true,
                   .gaps = true,
                   .late = Late::kCovered});
  }
  // Proved without delay only: bounds that jump, and the leak of a lost tick.
  all.push_back({.bounds = true});
  all.push_back({.late = Late::kLeak});
  all.push_back(
      {.noise_counts = 1, .lattice = true, .driver_rounds = true, .bounds = true, .gaps = true});
  return all;
}

}  // namespace enamel::station::lab
