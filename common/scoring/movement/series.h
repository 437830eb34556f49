#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/core/core.h"
#include "common/trace/trace.h"

namespace enamel::scoring {

// Gathers what the page plots over time, in at most 2000 steps of equally many ticks
// (schemas/api/openapi.yaml, Series), during the replay pass.
// Thread safety: none.
class SeriesRecorder {
 public:
  static constexpr uint64_t kMaxSteps = 2000;

  // `expected_ticks`: how many Adds will come (the seal says); more only add steps.
  SeriesRecorder(const core::CoreParams& params, double voxel_m, uint64_t expected_ticks);
  void Add(const trace::Tick& tick, const core::TickOutput& output);

  // The JSON text: times to 0.1 ms, forces to 1 mN, volumes to 1e-6 mm^3, positions to 0.1 um. Tissues that were never cut are left out. Deterministic. `pulp_m`:
  // how far a point is from the pulp; empty: there is none, and no such column. `felt_error`: by how much the force
  // in the hand was off (fidelity::FeltErrorOf), to 0.1 %; empty: no such member.
  std::string ToJson(const std::function<double(const dvec3&)>& pulp_m = {},
                     std::optional<double> felt_error = {}) const;
  uint32_t step_ticks() const { return step_ticks_; }

 private:
  struct Step {
    double t_s = 0;    // of its first tick, gaps included
    dvec3 force_n{0};  // the largest pressed
    double force_sum_n = 0;
    double computed_n = 0;            // largest, before the bounds
    double bound_n = 0;               // at its last tick
    dvec3 anchor_m{0};                // at its last tick
    cutting::RemovedUnits removed{};  // since the start
    uint32_t ticks = 0, late = 0;
  };

  // The bound as the core applied it: 0 while force and cutting are off (core.h, kSuspended).
  double Bound_n(const core::TickOutput& output) const;
  std::vector<double> Cumulative_mm3(size_t tissue) const;

  core::CoreParams params_;
  double voxel_m_;
  uint32_t step_ticks_;
  uint64_t time_ticks_ = 0;  // gaps included
  cutting::RemovedUnits removed_{};
  std::vector<Step> steps_;
};

}  // namespace enamel::scoring
