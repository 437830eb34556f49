#pragma once

#include <vector>

#include "common/core/core.h"

// A bur that has cut its way into a block is pulled back along its path, with the product's own
// core. Nothing is ahead of it, so nothing may hold it. SI units.
namespace enamel::station::lab {

enum class Cut { kSideMill, kPlunge, kSunkToTop, kPocket };
inline constexpr Cut kCuts[] = {Cut::kSideMill, Cut::kPlunge, Cut::kSunkToTop, Cut::kPocket};
const char* CutName(Cut cut);

struct NamedBur {
  const char* name;
  cutting::Bur bur;
};
// The built-in burs, the long ones shortened to fit the block.
const std::vector<NamedBur>& WithdrawalBurs();

// One withdrawal: fed in at 1 mm/s through enamel of 6.5 N s/mm, pulled out at the speed given.
struct Withdrawal {
  cutting::Bur bur;
  Cut cut = Cut::kPlunge;
  double speed_m_per_s = 0.03;
  bool turned = false;  // bur and way turned off the grid's axes
  haptics::LawKind law = haptics::kDefaultLaw;
  double hand_n_per_m = 0;  // 0: the hand prescribes the velocity; else 0.25 kg on that spring
  double beside_m = 0;      // how far beside its way in the bur is pulled back
  double kc_n_per_m = 10'000, cell_m = 9e-6, peak_force_n = 12;  // Omega 3DOF
};

struct WithdrawalFigures {
  double opposing_n = 0;  // largest part of the force against the withdrawal
  double rise_n = 0;      // its largest rise in a tick
  double other_n = 0;     // what a tick's growth of the force has beyond Kc (v T + sqrt(3) delta)
  double deepest_n = 0;   // largest force on the way in
  bool out = false;       // the bur has gone back with the tip
};

// Enamel 3 x 3 x 2.6 mm, top face z = 0, voxels of 0.05 mm.
cutting::Volume WithdrawalBlock();
// Deterministic. Thread safety: any thread; `block` is only read.
WithdrawalFigures RunWithdrawal(const Withdrawal& withdrawal, const cutting::Volume& block);

}  // namespace enamel::station::lab
