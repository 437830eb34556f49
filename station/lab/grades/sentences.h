#pragma once

#include <string>
#include <vector>

#include "common/scoring/score.h"

// Whether what a score says of a cut is true. The claims are checked against the volumes, voxel by voxel, and
// against what the regions paid; nothing here reads how the mistakes were found. Thread safety: functions, any
// thread.
namespace enamel::station::lab {

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
