#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/cutting/cutter.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/types.h"

// Runs an attempt without server, spool or threads: core, simulated device and operator in one
// loop. For trying a profile or an operator, and for tests.
namespace enamel::station {

// Distance of a cut plane from the exercise's box: positive when too far out (too deep).
struct PlaneError {
  std::string name;  // "mesial", …, "floor"
  double mean_um = 0;
  double median_um = 0;
  double rms_um = 0;
};

struct SimulationReport {
  uint64_t ticks = 0;
  uint64_t bounded_ticks = 0;
  uint64_t state_hash = 0;
  double seconds = 0;                                        // wall time
  double force_p50_n = 0, force_p95_n = 0, force_max_n = 0;  // sent, over ticks with any
  std::array<double, cutting::kTissueCount> removed_mm3{};
  std::vector<PlaneError> planes;
  bool finished = false;  // false: gave up after max_ticks
};

Result<SimulationReport> Simulate(const scene::BuiltScene& built, const scene::Exercise& exercise,
                                  const scene::DeviceProfile& profile,
                                  const std::string& operator_name, uint64_t seed = 0,
                                  uint64_t max_ticks = 600'000);

// Planes of `volume` against the exercise's box, measured along rays from inside the cavity.
std::vector<PlaneError> MeasureBox(const cutting::Volume& volume, const scene::Scene& scene,
                                   const scene::Exercise& exercise);

// mm^3 per tissue.
std::array<double, cutting::kTissueCount> Removed_mm3(const cutting::RemovedUnits& removed,
                                                      double voxel_m);

}  // namespace enamel::station
