#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/core/core.h"
#include "common/cutting/bur.h"

// The cost of a tick of the core: cut, engagement, force and hash, on a bur that moves sideways
// through a block and is engaged in every measured tick.
namespace enamel::station::lab {

// Position of the bur in the block.
enum class Sunk : uint8_t {
  kHalf,   // upright, half of its height below the surface
  kWhole,  // upright, all of it below the surface: a slot
  kLying,  // axis in the surface, across the travel
};
const char* SunkName(Sunk sunk);  // "half", "whole", "lying"

struct CutCase {
  cutting::Bur bur{cutting::BurShape::kCylinder, 0.6e-3, 4e-3};
  int32_t voxel_nm = 50'000;
  double speed_m_s = 5e-3;
  Sunk sunk = Sunk::kHalf;
  // Turns block, path and bur off the grid together, so that no face is along voxels.
  bool oblique = false;
  // Moves along its own axis into the block's top, from above it. Its `sunk` is not used.
  bool plunge = false;
  // Where the grid's samples lie: moved by this share of a voxel along each axis.
  dvec3 grid_at{0};
  // The bur's turn about its own axis, rad: which of its points are ahead.
  double spun_rad = 0;
  uint32_t rate_hz = 1000;

  double voxel_mm() const { return voxel_nm * 1e-6; }
};
// One case per bur shape, in the sizes of dental burs, the headline's cylinder first.
std::vector<CutCase> BurCases();

// The block's frame in the scene's, same origin.
class BlockFrame {
 public:
  explicit BlockFrame(const Quat& scene_from_block) : m_(scene_from_block.Matrix()) {}
  dvec3 ToScene(const dvec3& p) const { return m_ * p; }
  dvec3 ToBlock(const dvec3& p) const { return {Dot(m_[0], p), Dot(m_[1], p), Dot(m_[2], p)}; }

 private:
  dmat3 m_;
};

// A path through a block, as input to the core. The block's frame: solid where x > 0 and z < 0, and
// the bur moves along +x, or with `plunge` along -z.
struct CutPath {
  core::CoreParams params;
  cutting::Bur bur;  // as the core has it
  cutting::Volume block;
  Quat turn;  // scene from block
  bool plunge = false;
  double speed_m_s = 0;
  std::vector<core::TickInput> inputs;
  size_t first_measured = 0;  // before it: soft start, entry at 20 mm/s, settling
};
// `ticks`: the most to be measured; fewer where they would travel over 6 mm. Requires: a bur and a
// voxel the core accepts.
CutPath MakeCutPath(const CutCase& c, size_t ticks);

struct Spread {
  double mean = 0, p99 = 0;
};
// Mean and 99th percentile; zeros for nothing.
Spread SpreadOf(std::vector<double> values);

struct TickCost {
  size_t ticks = 0;
  int replays = 0;
  // For each tick the minimum of the replays; mean and 99th percentile over ticks.
  double mean_us = 0, p99_us = 0;
  // Over all ticks of all replays, unfiltered.
  double raw_mean_us = 0, raw_p99_us = 0;
  double removed_mm3 = 0;     // in the measured ticks
  double engaged_share = 0;   // of the measured ticks
  uint64_t state_hash = 0;    // after the last tick, the same in every replay
  bool replays_agree = true;  // they must: the core is deterministic
};

// Replays the path `replays` times on fresh cores and times every tick with the steady clock (about
// 25 ns of the clock's own are included). `progress` (done, all) may be empty. Blocks.
TickCost TimeTicks(const CutPath& path, int replays,
                   const std::function<void(int, int)>& progress = {});

}  // namespace enamel::station::lab
