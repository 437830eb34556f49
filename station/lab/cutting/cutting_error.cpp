#include "station/lab/cutting/cutting_error.h"

#include <algorithm>
#include <cmath>

#include "common/cutting/cutter.h"
#include "common/surface/surface.h"

namespace enamel::station::lab {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kProfileSteps = 4000, kSettleTicks = 100;

// Radius of the bur's body at a height above its tip, by bisection, since every shape provides only
// its distance. 0 where there is no body.
double RadiusAt(const cutting::Bur& bur, double height_m, double beyond_m) {
  double in = 0, out = beyond_m;
  if (bur.Distance(dvec3(0, 0, height_m)) >= 0) return 0;
  // 2^-60 of the interval: as accurate as a double.
  for (int i = 0; i < 60; ++i) {
    double middle = 0.5 * (in + out);
    (bur.Distance(dvec3(middle, 0, height_m)) < 0 ? in : out) = middle;
  }
  return in;
}

// Closed form of cutting_error.h, its integral over the depth by the midpoint rule.
double SlotVolume_m3(const CutPath& path, double end_x_m) {
  double depth = -path.tip_m.z, sum = 0, step = depth / kProfileSteps;
  for (int i = 0; i < kProfileSteps; ++i) {
    double r = RadiusAt(path.bur, (i + 0.5) * step, 4 * path.bur.radius_m);
    sum += (2 * r * end_x_m + 0.5 * kPi * r * r) * step;
  }
  return sum;
}

// Distance from the body swept along +x: the nearest position is the one beside the point.
double SlotDistance_m(const CutPath& path, double start_x_m, double end_x_m, const dvec3& p) {
  double x = std::clamp(p.x, start_x_m, end_x_m);
  return path.bur.Distance(p - dvec3(x, path.tip_m.y, path.tip_m.z));
}

struct Run {
  std::vector<dvec3> force_n;  // measured ticks
  dvec3 end_m{0};              // the anchor's tip at the end, in the block's frame
  double removed_m3 = 0;
  surface::Mesh mesh;
};

Run RunOnce(const CutPath& path) {
  core::Core core(path.params, path.block);
  Run out;
  BlockFrame frame(path.turn);
  for (size_t i = 0; i < path.inputs.size(); ++i) {
    core::TickOutput tick = core.Step(path.inputs[i]);
    if (i >= path.first_measured) out.force_n.push_back(tick.force_sent_n);
  }
  // Until the hand's last step is cut.
  for (int i = 0; i < kSettleTicks; ++i) {
    dvec3 at = core.Step(path.inputs.back()).anchor.tip_m;
    out.end_m = frame.ToBlock(at);
  }
  double voxel_m = path.block.spec().voxel_m();
  for (int64_t units : core.removed()) out.removed_m3 += cutting::RemovedUnitsToM3(units, voxel_m);
  out.mesh = surface::ExtractSurface(core.volume());
  return out;
}

void MeasureSurface(const CutPath& path, const Run& run, CuttingFigures& f) {
  BlockFrame frame(path.turn);
  double inside = 1.5 * path.block.spec().voxel_m(), start_x = -10 * path.bur.radius_m;
  std::vector<double> off;
  for (const glm::vec3& position : run.mesh.position_m) {
    dvec3 p = frame.ToBlock(dvec3(position));
    // Without the block's top and front, where the slot's edge is partly the block's.
    if (p.z > -inside || p.x < inside) continue;
    double d = std::fabs(SlotDistance_m(path, start_x, run.end_m.x, p));
    // The block's own outside is farther away from any bur.
    if (d < 4 * path.block.spec().voxel_m()) off.push_back(d * 1e6);
  }
  f.vertices = off.size();
  if (off.empty()) return;
  std::sort(off.begin(), off.end());
  for (double d : off) f.deviation_mean_um += d / static_cast<double>(off.size());
  f.deviation_p95_um = off[off.size() * 95 / 100];
}

double Length(const dvec3& v) { return std::sqrt(Dot(v, v)); }

double MeanLength(const std::vector<dvec3>& v) {
  double sum = 0;
  for (const dvec3& x : v) sum += Length(x);
  return v.empty() ? 0 : sum / static_cast<double>(v.size());
}

double ForceError(const std::vector<dvec3>& a, const std::vector<dvec3>& finest) {
  size_t n = std::min(a.size(), finest.size());
  double sum = 0;
  for (size_t i = 0; i < n; ++i) sum += Length(a[i] - finest[i]);
  double whole = MeanLength(finest) * static_cast<double>(n);
  return whole > 0 ? sum / whole : 0;
}

}  // namespace

CuttingPlan DefaultCuttingPlan(bool quick) {
  CuttingPlan plan;
  plan.voxels_nm = {100'000, 50'000};
  if (!quick) plan.voxels_nm.push_back(25'000);
  if (quick) plan.ticks = 300;
  for (CutCase c : BurCases()) {
    c.oblique = true;
    for (double speed : {1e-3, 5e-3, 20e-3}) {
      c.speed_m_s = speed;
      if (!quick || speed == 5e-3) plan.cases.push_back(c);
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
    std::vector<std::vector<dvec3>> forces;
    size_t first = out.size();
    for (int32_t voxel_nm : plan.voxels_nm) {
      c.voxel_nm = voxel_nm;
      if (progress)
        progress(BurText(c) + " at " + std::to_string(voxel_nm / 1000) + " um", out.size(), all);
      CutPath path = MakeCutPath(c, plan.ticks);
      CuttingFigures f;
      f.c = c;
      f.cost = TimeTicks(path, plan.replays);
      Run run = RunOnce(path);
      f.removed_mm3 = run.removed_m3 * 1e9;
      f.analytic_mm3 = SlotVolume_m3(path, run.end_m.x) * 1e9;
      f.volume_error = f.removed_mm3 / f.analytic_mm3 - 1;
      MeasureSurface(path, run, f);
      f.force_mean_n = MeanLength(run.force_n);
      forces.push_back(std::move(run.force_n));
      out.push_back(f);
    }
    for (size_t i = 0; i < forces.size(); ++i) {
      // The finest voxel is last: no closed form is known for the force of a turned slot.
      out[first + i].force_error = ForceError(forces[i], forces.back());
    }
  }
  if (progress) progress("cutting", all, all);
  return out;
}

}  // namespace enamel::station::lab
