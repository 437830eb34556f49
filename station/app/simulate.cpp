#include "station/app/simulate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "common/core/core.h"
#include "common/scene/plan.h"
#include "common/scene/tooth_number.h"
#include "station/devices/operators.h"
#include "station/loop/tick_loop.h"

namespace enamel::station {
namespace {

// A tenth of a usual voxel: within such a step, distance is close to linear and the crossing is
// interpolated.
constexpr double kRayStep_m = 5e-6;
constexpr double kRayReach_m = 2e-3;
// 441 rays a plane: the median is good to some um even if a wall is rough to 35 um rms.
constexpr int kRaysPerSide = 21;

// Distance along a ray from air to the volume's surface, m.
std::optional<double> March(const cutting::Volume& volume, const dvec3& from, const dvec3& along) {
  double before = volume.DistanceAt_m(from);
  // The ray begins in tissue: nothing was cut there, so a distance has no meaning.
  if (before <= 0) return std::nullopt;
  for (double s = kRayStep_m; s < kRayReach_m; s += kRayStep_m) {
    double here = volume.DistanceAt_m(from + along * s);
    if (here <= 0) return s - kRayStep_m * here / (here - before);
    before = here;
  }
  return std::nullopt;
}

// One plane of the box: its middle, outward normal, and the half extents to measure.
struct Plane {
  const char* name;
  dvec3 middle, outward, across, up;
};

PlaneError Measure(const cutting::Volume& volume, const Plane& plane, double back_m) {
  std::vector<double> errors;
  for (int i = 0; i < kRaysPerSide; ++i) {
    for (int j = 0; j < kRaysPerSide; ++j) {
      double u = 2.0 * i / (kRaysPerSide - 1) - 1, v = 2.0 * j / (kRaysPerSide - 1) - 1;
      dvec3 from = plane.middle + plane.across * u + plane.up * v - plane.outward * back_m;
      if (auto hit = March(volume, from, plane.outward)) errors.push_back((*hit - back_m) * 1e6);
    }
  }
  PlaneError out;
  out.name = plane.name;
  if (errors.empty()) {
    out.mean_um = out.median_um = out.rms_um = std::nan("");
    return out;
  }
  std::sort(errors.begin(), errors.end());
  out.median_um = errors[errors.size() / 2];
  double squares = 0;
  for (double e : errors) {
    out.mean_um += e / static_cast<double>(errors.size());
    squares += e * e / static_cast<double>(errors.size());
  }
  out.rms_um = std::sqrt(squares);
  return out;
}

}  // namespace

std::array<double, cutting::kTissueCount> Removed_mm3(const cutting::RemovedUnits& removed,
                                                      double voxel_m) {
  std::array<double, cutting::kTissueCount> out{};
  // The core counts in 65536ths of a voxel, so that sums are exact and the same on every machine.
  double unit = voxel_m * voxel_m * voxel_m * 1e9 / 65536;
  for (size_t t = 0; t < out.size(); ++t) out[t] = static_cast<double>(removed[t]) * unit;
  return out;
}

std::vector<PlaneError> MeasureBox(const cutting::Volume& volume, const scene::Scene& scene,
                                   const scene::Exercise& exercise) {
  const scene::PointUm& at = scene.landmarks.at(exercise.target.landmark);
  dvec3 centre = dvec3(at[0], at[1], at[2]) * 1e-6;
  double hx = exercise.target.half_size_um[0] * 1e-6, hy = exercise.target.half_size_um[1] * 1e-6;
  double depth = exercise.target.depth_um * 1e-6, r = exercise.bur_radius_um * 1e-6;
  // Walls: from 0.2 mm above the floor to the middle of the depth, without the round corners.
  double low = -depth + 0.2e-3, high = -0.5 * depth;
  double middle_z = 0.5 * (low + high), half_z = 0.5 * (high - low);
  auto wall = [&](const char* name, const dvec3& out, double distance, double flat) {
    dvec3 across = out.x != 0 ? dvec3(0, flat, 0) : dvec3(flat, 0, 0);
    return Plane{name, centre + out * distance + dvec3(0, 0, middle_z), out, across,
                 dvec3(0, 0, half_z)};
  };
  const dvec3 mesial(scene::MesialX(scene.tooth), 0, 0);
  const Plane planes[] = {wall("mesial", mesial, hx, hy - r),
                          wall("distal", -mesial, hx, hy - r),
                          wall("buccal", dvec3(0, 1, 0), hy, hx - r),
                          wall("lingual", dvec3(0, -1, 0), hy, hx - r),
                          {"floor", centre - dvec3(0, 0, depth), dvec3(0, 0, -1),
                           dvec3(hx - r, 0, 0), dvec3(0, hy - r, 0)}};
  std::vector<PlaneError> out;
  // From a bur's radius in front of each wall, in the air of any cavity the bur has made.
  for (const Plane& plane : planes) out.push_back(Measure(volume, plane, r));
  return out;
}

Result<SimulationReport> Simulate(const scene::BuiltScene& built, const scene::Exercise& exercise,
                                  const scene::DeviceProfile& profile,
                                  const std::string& operator_name, uint64_t seed,
                                  uint64_t max_ticks) {
  const OperatorPreset* preset = FindOperator(operator_name);
  if (preset == nullptr) {
    return Status(Code::kNotFound, "no operator '" + operator_name + "'", "operator");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto params, scene::CompilePlan(built.scene, exercise, profile));
  ENAMEL_ASSIGN_OR_RETURN(auto device, MakeSimulatedDevice(*preset, built.scene, exercise, profile,
                                                           params, built.volume, seed));
  core::Core core(params, built.volume);
  // Emptied after every tick, so that it never holds more than one.
  SampleRing ring(4);
  TickLoop loop(*device, core, ring, {params.rate_hz, true, false});
  SimulationReport report;
  std::vector<double> forces;
  auto begin = std::chrono::steady_clock::now();
  while (!report.finished && report.ticks < max_ticks) {
    report.finished = loop.Tick();
    Sample sample;
    while (ring.Pop(sample)) ++report.ticks;
    dvec3 f = loop.snapshot().pressed_n;
    // Only ticks with force: time in the air would lower every quantile.
    if (double n = std::sqrt(Dot(f, f)); n > 0) forces.push_back(n);
  }
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  report.bounded_ticks = loop.snapshot().counters.bounded_ticks;
  report.state_hash = core.state_hash();
  std::sort(forces.begin(), forces.end());
  if (!forces.empty()) {
    report.force_p50_n = forces[forces.size() / 2];
    report.force_p95_n = forces[forces.size() * 95 / 100];
    report.force_max_n = forces.back();
  }
  report.removed_mm3 = Removed_mm3(core.removed(), built.volume.spec().voxel_m());
  report.planes = MeasureBox(core.volume(), built.scene, exercise);
  return report;
}

}  // namespace enamel::station
