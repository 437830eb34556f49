#pragma once

#include "common/scoring/mistakes/groups.h"
#include "common/scoring/mistakes/mistakes.h"

// The kind, place and size of a group of motions as a mistake. Private to mistakes.cpp.
namespace enamel::scoring {

struct NamedFrom {
  const AcceptableCut& r;
  const FaultVolumes& faults;
  const std::vector<double>& off_mm;   // of FaultVolumes
  const std::vector<double>& rest_mm;  // the same less what the other groups explain
  const std::vector<bool>& wavy;       // by region: IsWavy
  // Points that the group costs, by region: a patch is named after a region that pays for it.
  const std::vector<double>& paid;
};
// Sets kind, place, size and towards. Requires: m.at_m.
void NameMistake(const NamedFrom& from, const MotionGroup& group, Mistake& m);

// Volume of what was left at pieces, if it stands away from R's surface; else 0.
template <typename Counts>
double Standing_mm3(const FaultVolumes& faults, const Counts& counts) {
  // Root mean square beyond the leeway. Chosen.
  constexpr double kStandsFrom_m = 0.5e-3;
  double volume = 0, moment = 0;
  for (size_t i = 0; i < faults.left.size(); ++i) {
    if (!counts(i)) continue;
    volume += faults.left[i].volume_m3, moment += faults.left[i].moment_m5;
  }
  return volume > 0 && moment > kStandsFrom_m * kStandsFrom_m * volume ? volume * 1e9 : 0;
}

}  // namespace enamel::scoring
