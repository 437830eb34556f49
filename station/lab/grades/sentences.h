#pragma once

#include <string>
#include <vector>

#include "common/scoring/score.h"

// Whether what a score says of a cut is true. The claims are checked against the volumes, voxel by voxel, and
// against what the regions paid; nothing here reads how the mistakes were found. Thread safety: functions, any
// thread.
namespace enamel::station::lab {

// A mistake speaks of tissue that was cut too far, of tissue that was left, or of both.
struct Sides {
  bool over = false, left = false;
};
Sides SidesOf(scoring::MistakeKind kind);
// True where a mistake's place is this region, all regions of its kind, or the whole.
bool IsAt(const scoring::Region& region, const std::string& place);

struct Sentences {
  size_t said = 0;                 // mistakes with points
  std::vector<std::string> wrong;  // "over_extended at wall_distal: nothing was cut too far there"
};

// A mistake is true where its place lost points on the side that it names, and where the attempt lacks, or holds,
// tissue on that side beyond the leeway.
Sentences CheckSentences(const scoring::AcceptableCut& r, const cutting::Volume& attempt,
                         const std::vector<scoring::RegionMeasure>& measures,
                         const std::vector<scoring::RegionCost>& costs,
                         const std::vector<scoring::Mistake>& mistakes);

}  // namespace enamel::station::lab
