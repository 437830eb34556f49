#pragma once

#include "station/lab/laws/model.h"

// A bur that has cut is drawn back and comes again through air, fast, up to the place where it had been.
// The spring's tank is full from the first cut. SI units.
namespace enamel::station::lab {

struct Approach {
  haptics::LawKind law = haptics::kDefaultLaw;
  double speed_m_per_s = 50e-3;  // in air
  double b_n_s_per_m = 6500;
  double cut_m_per_s = 0.43e-3;
  bool goes_on = false;  // comes on as it came, until it is felt; else it cuts on from the surface
  bool wall = false;     // comes on against a still bur's wall, and not tissue
};

struct ApproachFigures {
  double excess_n = 0;  // of a bur that cuts on: most of R along the way beyond B v
  double way_m = 0;     // the tip's way past the surface before the force is 0.1 N
  double behind_m = 0;  // farthest that the bur was behind the tip in air
};

// Prescribed by the hand. Deterministic. Thread safety: any thread.
ApproachFigures RunApproach(const DeviceModel& model, const Approach& approach);

}  // namespace enamel::station::lab
