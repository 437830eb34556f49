#include <algorithm>
#include <cmath>

#include "common/core/params.h"
#include "common/scene/cell.h"
#include "station/lab/suites/adversary.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {

scene::DeviceProfile GameRules::ProfileOf(const DeviceModel& m) const {
  scene::DeviceProfile profile = m.profile;
  const auto cell_nm = static_cast<int32_t>(profile.resolution_nm.value);
  profile.cell = {lattice, lattice && !driver_rounds ? kRecorded_nm : cell_nm, noise_counts, ""};
  return profile;
}

haptics::TipCell CellUnder(const DeviceModel& m, const GameRules& rules) {
  const scene::TipCellNm cell = scene::TipCellOf(rules.ProfileOf(m));
  core::CoreParams p;
  p.cell_half_nm.fill(cell.half_nm);
  p.cell_ball_nm = cell.ball_nm;
  return core::TipCellOf(p);
}

std::string GameRules::Name() const {
  std::string name = "delay " + std::to_string(delay_ticks);
  if (untold_ticks > 0) name += " and " + std::to_string(untold_ticks) + " untold";
  if (rate_hz != 1000) name += ", " + F(rate_hz, "%.0f") + " Hz";
  if (noise_counts > 0) name += ", noise " + std::to_string(noise_counts);
  if (untold_counts > 0) name += ", untold noise " + std::to_string(untold_counts);
  if (lattice) name += driver_rounds ? ", turned lattice rounded again" : ", turned lattice";
  if (bounds) name += ", bounds jump";
  if (gaps) name += ", gaps";
  if (late == Late::kCovered) name += ", late ticks (clause of one more)";
  if (late == Late::kLeak) name += ", lost ticks (leak)";
  if (over_clause != 1) name += ", Kc " + F(over_clause, "%.1f") + " times the clause's";
  return name;
}

double ClauseStiffness(const DeviceModel& m, const GameRules& rules) {
  const DeviceModel at = AtRate(m, rules.rate_hz, rules.rate_hz != m.rate_hz);
  const double ticks = rules.clause_ticks() + 1;
  // Kc <= 2 b/((d + 1)^2 T), the clause of README.md.
  const double most = 2 * at.damping_n_s_per_m / (ticks * ticks * at.tick_s());
  return std::floor(rules.over_clause * std::min(at.kc_n_per_m, most));
}

double ClauseFriction(const DeviceModel& m, const GameRules& rules, const Target& target) {
  const double clause_kc = ClauseStiffness(m, rules) / rules.over_clause;
  return clause_kc * scene::CellSupportNm(rules.ProfileOf(m)) * 1e-9 * (target.spare ? 1.5 : 1);
}

std::string Target::Name() const {
  const std::string name = law ? std::string(haptics::FindLaw(*law)->name) : "guard alone";
  return name + (core ? ", whole core" : "") + (spare ? ", friction to spare" : "");
}

bool Covered(const Target& target, const GameRules& rules) {
  if (rules.untold_ticks > 0 || rules.untold_counts > 0 || rules.over_clause > 1) return false;
  return !target.law || ProvedLaw(*target.law);
}

std::vector<GameRules> ExcludedRules() {
  return {
      {.untold_ticks = 1},
      {.untold_counts = 1},
      {.over_clause = 2},
      {.delay_ticks = 1, .over_clause = 2},
      {.noise_counts = 1, .lattice = true, .driver_rounds = true, .gaps = true, .over_clause = 2}};
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
  for (double rate_hz : {4000.0, 8000.0}) {
    all.push_back({.rate_hz = rate_hz});
    all.push_back({.rate_hz = rate_hz,
                   .delay_ticks = 1,
                   .lattice = true,
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
