#pragma once

#include <vector>

#include "common/scoring/align.h"
#include "common/scoring/metrics.h"

// Aligns two recordings: which moment or place of one matches which of the other. The alignment
// metrics are means over it, and the side-by-side view follows it. Deterministic. Thread safety:
// functions, any thread.
namespace enamel::scoring {

// By time, pauses and speeds count; by the bur's way, only where it went.
enum class PathBy { kTime, kArcLength };

// Both series with one step, or a slow attempt would be compared at another step than its
// reference.
//  * By time: at most 25 Hz; the pose of a step's first tick and its mean force.
//  * By way: at least 20 um apart; pose and force between the two samples around, linearly.
// At most kMaxSamples each.
struct PathPair {
  static constexpr size_t kMaxSamples = 3000;
  std::vector<PathSample> attempt, reference;
};
// Requires: each with a tick.
PathPair ResampleAlike(const ProcessRecorder& attempt, const ProcessRecorder& reference, PathBy by);

// The cheapest pairing in a band of a tenth of the longer series: at most 1.8 million cells. Its
// path: indices into `attempt` and `reference`. Costs: m, and N.
Alignment AlignPoses(const PathPair& paths, Pairing pairing = Pairing::kSum);
Alignment AlignForces(const PathPair& paths);

}  // namespace enamel::scoring
