#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/cutting/bur.h"
#include "station/lab/cutting/tick_cost.h"

// What other people's level sets cost where ours cuts: the same bur, poses and voxel. Blocks.
namespace enamel::station::lab::bench {

struct PeerCost {
  std::string what;
  // Per tick the least of the replays; mean and 99th percentile over the measured ticks.
  double mean_us = 0, p99_us = 0;
  double removed_mm3 = 0;  // along the whole path, entry included
};

// Where the core cut in each tick of the path.
std::vector<cutting::Pose> PosesOf(const CutPath& path);

// The core's own cutter alone: no engagement, force or hash.
PeerCost TimeCutter(const CutPath& path, const std::vector<cutting::Pose>& poses, int replays);

// Whether the program was built with OpenVDB (Debian: libopenvdb-dev).
bool HasOpenVdb();

// OpenVDB's narrow-band level set, filled with the block's own samples, one thread, in two ways: the
// bur's distance put into the tooth's voxels through an accessor (the least that has to be done), and
// its level set built anew and taken off with csgDifference (as its manual does it). Requires:
// HasOpenVdb.
std::vector<PeerCost> TimeOpenVdb(const CutPath& path, const std::vector<cutting::Pose>& poses,
                                  int replays);

}  // namespace enamel::station::lab::bench
