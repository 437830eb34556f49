#include "station/lab/bench/peers.h"

#include <algorithm>
#include <chrono>

#include "common/cutting/cutter.h"

namespace enamel::station::lab::bench {

std::vector<cutting::Pose> PosesOf(const CutPath& path) {
  core::Core core(path.params, path.block);
  std::vector<cutting::Pose> out;
  // The core's poses of the bur, so that all cut in the same places.
  for (const core::TickInput& in : path.inputs) out.push_back(core.Step(in).anchor);
  return out;
}

PeerCost TimeCutter(const CutPath& path, const std::vector<cutting::Pose>& poses, int replays) {
  PeerCost cost{.what = "this cutter alone"};
  std::vector<double> least(poses.size() - path.first_measured, 1e12);
  for (int r = 0; r < replays; ++r) {
    // Each replay cuts a whole block: a second one through the same slot would remove nothing.
    cutting::Volume volume = path.block;
    // As the core does before an attempt: no tick allocates.
    volume.Reserve();
    cutting::Cutter cutter(volume, path.bur);
    cutting::RemovedUnits removed{};
    for (size_t i = 0; i < poses.size(); ++i) {
      auto from = std::chrono::steady_clock::now();
      cutter.Cut(poses[i], removed);
      std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - from;
      if (i < path.first_measured) continue;
      double& best = least[i - path.first_measured];
      best = std::min(best, took.count());
    }
    int64_t all = 0;
    for (int64_t units : removed) all += units;
    cost.removed_mm3 = cutting::RemovedUnitsToM3(all, volume.spec().voxel_m()) * 1e9;
  }
  Spread spread = SpreadOf(std::move(least));
  cost.mean_us = spread.mean, cost.p99_us = spread.p99;
  return cost;
}

#ifndef ENAMEL_HAS_OPENVDB
bool HasOpenVdb() { return false; }
std::vector<PeerCost> TimeOpenVdb(const CutPath&, const std::vector<cutting::Pose>&, int) {
  return {};
}
#endif

}  // namespace enamel::station::lab::bench
