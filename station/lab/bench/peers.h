#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/cutting/bur.h"
#include "station/lab/cutting/tick_cost.h"

// The cost of other projects' level sets for the same cut: same bur, poses and voxel. Blocks.
namespace enamel::station::lab::bench {

struct PeerCost {
  std::string what;
  // For each tick the minimum of the replays; mean and 99th percentile over the measured ticks.
  double mean_us = 0, p99_us = 0;
  double removed_mm3 = 0;  // along the whole path, entry included
};

// Pose of the core's cut in each tick of the path.
std::vector<cutting::Pose> PosesOf(const CutPath& path);

// The core's own cutter alone: no engagement, force or hash.
PeerCost TimeCutter(const CutPath& path, const std::vector<cutting::Pose>& poses, int replays);

// Whether the program was built with OpenVDB (Debian: libopenvdb-dev).
bool HasOpenVdb();

// OpenVDB's narrow-band level set, filled with the block's own samples, one thread, in two ways:
// the bur's distance written into the tooth's voxels through an accessor (the minimum work), and
// its level set rebuilt and subtracted with csgDifference (as in its manual). Requires: HasOpenVdb.
std::vector<PeerCost> TimeOpenVdb(const CutPath& path, const std::vector<cutting::Pose>& poses,
                                  int replays);

}  // namespace enamel::station::lab::bench
