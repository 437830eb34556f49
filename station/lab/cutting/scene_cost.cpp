#include "station/lab/cutting/scene_cost.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/surface/surface.h"
#include "station/lab/cutting/tick_cost.h"

namespace enamel::station::lab {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kEntry_m_s = 20e-3, kCut_m_s = 5e-3;
constexpr double kStartHeight_m = 8e-3;  // plan.h: count 0 above the landmark
constexpr int kNotEngaged = int{haptics::kFreeAir} | int{core::kSuspended};

class InputsOf {
 public:
  explicit InputsOf(const core::CoreParams& params) : params_(params) {}
  // Tip relative to where the counts are zero.
  core::TickInput At(const dvec3& tip_m) const {
    core::TickInput in;
    for (size_t i = 0; i < 3; ++i) {
      in.counts[i] = static_cast<int32_t>(
          std::lround(tip_m[static_cast<int>(i)] * 1e9 / params_.resolution_nm[i]));
    }
    in.flags = core::kBurOn;
    in.bur_speed_krpm = 200;
    return in;
  }

 private:
  const core::CoreParams& params_;
};

double MicrosecondsSince(Clock::time_point from) {
  return std::chrono::duration<double, std::micro>(Clock::now() - from).count();
}

}  // namespace

CutWay MakeCutWay(const core::CoreParams& params, const scene::CavityTarget& target, size_t ticks) {
  InputsOf inputs(params);
  CutWay way;
  for (uint32_t i = 0; i < params.soft_start_ticks + 20; ++i) way.inputs.push_back(inputs.At({}));
  double bottom = -(kStartHeight_m + 0.5e-6 * target.depth_um);
  double down = kEntry_m_s / params.rate_hz;
  for (double z = 0; z > bottom; z -= down) way.inputs.push_back(inputs.At({0, 0, z}));
  way.first_measured = way.inputs.size();
  double widest = 0.8e-6 * std::min(target.half_size_um[0], target.half_size_um[1]);
  // An outward spiral: every tick has uncut tissue ahead, and it stays inside the box.
  double angle = 0;
  for (size_t i = 0; i < ticks; ++i) {
    double radius = widest * (0.2 + 0.8 * static_cast<double>(i) / static_cast<double>(ticks));
    angle += kCut_m_s / params.rate_hz / radius;
    way.inputs.push_back(inputs.At({radius * std::cos(angle), radius * std::sin(angle), bottom}));
  }
  return way;
}

StepCost MeasureSteps(const core::CoreParams& params, const cutting::Volume& volume,
                      const CutWay& way, int replays) {
  std::vector<double> least(way.inputs.size() - way.first_measured, 1e12);
  StepCost cost;
  for (int r = 0; r < replays; ++r) {
    core::Core core(params, volume);
    size_t engaged = 0;
    for (size_t i = 0; i < way.inputs.size(); ++i) {
      auto from = Clock::now();
      core::TickOutput out = core.Step(way.inputs[i]);
      double us = MicrosecondsSince(from);
      if (i < way.first_measured) continue;
      double& kept = least[i - way.first_measured];
      // The same tick of every replay, to exclude the computer's other work.
      kept = std::min(kept, us);
      engaged += (out.flags & kNotEngaged) == 0;
    }
    cost.engaged_share = static_cast<double>(engaged) / static_cast<double>(least.size());
    int64_t removed = 0;
    for (int64_t units : core.removed()) removed += units;
    cost.removed_mm3 = cutting::RemovedUnitsToM3(removed, volume.spec().voxel_m()) * 1e9;
    cost.state_hash = core.state_hash();
    cost.volume_mb = 1e-6 * static_cast<double>(core.volume().MemoryBytes());
  }
  Spread spread = SpreadOf(std::move(least));
  cost.mean_us = spread.mean;
  cost.p99_us = spread.p99;
  return cost;
}

SurfaceCost MeasureSurface(const core::CoreParams& params, const cutting::Volume& volume,
                           const CutWay& way) {
  SurfaceCost cost;
  surface::Mesh whole = surface::ExtractSurface(volume);
  // Position and normal per vertex, one byte of tissue, and the triangles.
  cost.mb = 1e-6 * static_cast<double>(whole.position_m.size() * 2 * sizeof(glm::vec3) +
                                       whole.tissue.size() +
                                       whole.triangles.size() * sizeof(whole.triangles[0]));
  core::Core core(params, volume);
  size_t ticks = 0;
  constexpr size_t kEvery = 10;  // as many ticks are looked at; the others only cut
  for (size_t i = 0; i < way.inputs.size(); ++i) {
    core.Step(way.inputs[i]);
    if (i < way.first_measured || i % kEvery != 0) continue;
    auto from = Clock::now();
    for (int32_t brick : core.touched()) surface::ExtractBrick(core.volume(), brick);
    cost.us_per_tick += MicrosecondsSince(from);
    ++ticks;
  }
  if (ticks > 0) cost.us_per_tick /= static_cast<double>(ticks);
  return cost;
}

}  // namespace enamel::station::lab
