#include "station/lab/cutting/cutting_error.h"

#include <algorithm>
#include <cmath>

#include "common/cutting/cutter.h"
#include "common/cutting/voxel_limit.h"
#include "common/surface/surface.h"
#include "station/lab/cutting/swept_body.h"

namespace enamel::station::lab {
namespace {

constexpr int kSettleTicks = 100;

double Length(const dvec3& v) { return std::sqrt(Dot(v, v)); }

void MeasureSurface(const CutPath& path, const SweptBody& body, const cutting::Volume& volume,
                    CutErrors& out) {
  BlockFrame frame(path.turn);
  const double voxel = volume.spec().voxel_m(), inside = 1.5 * voxel;
  std::vector<double> off;
  for (const glm::vec3& position : surface::ExtractSurface(volume).position_m) {
    dvec3 p = frame.ToBlock(dvec3(position));
    // Without the block's top and front, where the hole's edge is partly the block's.
    if (p.z > -inside || p.x < inside) continue;
    double d = std::fabs(body.Distance_m(p));
    // The block's own outside is farther away from any bur.
    if (d < 4 * voxel) off.push_back(d * 1e6);
  }
  out.vertices = off.size();
  if (off.empty()) return;
  std::sort(off.begin(), off.end());
  for (double d : off) out.surface_mean_um += d / static_cast<double>(off.size());
  out.surface_p95_um = off[off.size() * 95 / 100];
}

void MeasureForce(const std::vector<dvec3>& force_n, const dvec3& reference_n, CutErrors& out) {
  if (force_n.empty()) return;
  dvec3 mean(0);
  for (const dvec3& f : force_n) mean += f / static_cast<double>(force_n.size());
  out.force_mean_n = Length(mean);
  out.force = Length(mean - reference_n) / Length(reference_n);
}

CutErrors RunOnce(const CutPath& path) {
  core::Core core(path.params, path.block);
  BlockFrame frame(path.turn);
  std::vector<dvec3> force_n, tips_m;
  for (size_t i = 0; i < path.inputs.size(); ++i) {
    core::TickOutput tick = core.Step(path.inputs[i]);
    tips_m.push_back(frame.ToBlock(tick.anchor.tip_m));
    if (i >= path.first_measured) force_n.push_back(frame.ToBlock(tick.force_sent_n));
  }
  // Until the hand's last step is cut.
  for (int i = 0; i < kSettleTicks; ++i)
    tips_m.push_back(frame.ToBlock(core.Step(path.inputs.back()).anchor.tip_m));
  const SweptBody body(path, std::move(tips_m));
  const double voxel_m = path.block.spec().voxel_m();
  CutErrors out;
  for (int64_t units : core.removed())
    out.removed_mm3 += cutting::RemovedUnitsToM3(units, voxel_m) * 1e9;
  out.analytic_mm3 = body.Volume_m3() * 1e9;
  out.volume = out.removed_mm3 / out.analytic_mm3 - 1;
  MeasureSurface(path, body, core.volume(), out);
  MeasureForce(force_n, body.Force_n(), out);
  return out;
}

}  // namespace

dvec3 GridAt(size_t i) {
  auto n = static_cast<double>(i);
  dvec3 at(0.8191725133961645 * n, 0.6710436067037893 * n, 0.5497004779019703 * n);
  return at - dvec3(std::floor(at.x), std::floor(at.y), std::floor(at.z));
}

CuttingPlan DefaultCuttingPlan(bool quick) {
  CuttingPlan plan;
  plan.voxels_nm = {100'000, 50'000};
  if (!quick) plan.voxels_nm.push_back(25'000);
  if (quick) plan.ticks = 300;
  for (CutCase c : BurCases()) {
    c.oblique = true;
    for (double speed : {1e-3, 5e-3, 20e-3}) {
      c.speed_m_s = speed;
      for (bool plunge : {false, true}) {
        c.plunge = plunge;
        if (!quick || (speed == 5e-3 && !plunge)) plan.cases.push_back(c);
      }
    }
  }
  if (quick) plan.cases.resize(std::min<size_t>(plan.cases.size(), 2));
  return plan;
}

std::vector<CuttingFigures> MeasureCutting(
    const CuttingPlan& plan,
    const std::function<void(const std::string&, size_t, size_t)>& progress) {
  std::vector<CuttingFigures> out;
  size_t all = plan.cases.size() * plan.voxels_nm.size();
  for (CutCase c : plan.cases) {
    for (int32_t voxel_nm : plan.voxels_nm) {
      c.voxel_nm = voxel_nm;
      if (progress)
        progress(BurText(c.bur) + " at " + std::to_string(voxel_nm / 1000) + " um", out.size(),
                 all);
      CuttingFigures f;
      f.c = c;
      for (size_t i = 0; i < plan.grids; ++i) {
        c.grid_at = GridAt(i);
        CutPath path = MakeCutPath(c, plan.ticks);
        if (i == 0) f.cost = TimeTicks(path, plan.replays);
        f.grids.push_back(RunOnce(path));
      }
      out.push_back(std::move(f));
    }
  }
  if (progress) progress("cutting", all, all);
  return out;
}

}  // namespace enamel::station::lab
