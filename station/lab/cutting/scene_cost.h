#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/core/core.h"
#include "common/scene/types.h"

// The cost of a scene on this machine, measured when called. Nothing is stored, and a busy machine
// gives higher figures. Blocks; not real-time.
namespace enamel::station::lab {

// A path of the hand for a scene's exercise: soft start in free air, down at the landmark, then a
// widening circle inside the target. The bur follows through the device's spring and is engaged in
// nearly every measured tick.
struct CutWay {
  std::vector<core::TickInput> inputs;
  size_t first_measured = 0;
};
CutWay MakeCutWay(const core::CoreParams& params, const scene::CavityTarget& target, size_t ticks);

struct StepCost {
  double mean_us = 0, p99_us = 0;  // over ticks, each the minimum of all replays
  double removed_mm3 = 0;          // in all ticks
  double engaged_share = 0;        // of the measured ticks
  double volume_mb = 0;            // of the tooth after all ticks
  uint64_t state_hash = 0;
};
// Times every tick of `replays` runs on fresh cores with the steady clock (its own 25 ns or so
// included). `volume` is copied per run.
StepCost MeasureSteps(const core::CoreParams& params, const cutting::Volume& volume,
                      const CutWay& way, int replays);

// Triangles of the region a tick's cut touched: mean time to renew them (off the tick's thread),
// and the memory of the whole surface.
struct SurfaceCost {
  double us_per_tick = 0;
  double mb = 0;
};
SurfaceCost MeasureSurface(const core::CoreParams& params, const cutting::Volume& volume,
                           const CutWay& way);

}  // namespace enamel::station::lab
