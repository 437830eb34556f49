#include <cmath>
#include <numbers>

#include "common/scoring/metrics.h"
#include "station/lab/grades/grades.h"
#include "station/lab/grades/hollow.h"
#include "station/lab/suites/orders.h"
#include "station/lab/suites/suites.h"

namespace enamel::station::lab {
namespace {

constexpr size_t kGrids = 8;
constexpr double kTurn_deg = 7;  // of the cavity about z: no wall lies along voxels
constexpr double kWall_m = 0.13e-3, kFloor_m = 0.17e-3, kLean_deg = 5;

// The block's exercise, which asks for the block's cavity.
struct BlockTask {
  scene::Scene scene;
  scene::Exercise exercise;
};
BlockTask MakeBlockTask() {
  const BoxCavity cavity = FaultBlockCavity();
  BlockTask out;
  out.scene.landmarks["occlusal_centre"] = {0, 0, 0};
  auto Um = [](double m) { return static_cast<int32_t>(std::lround(m * 1e6)); };
  out.exercise.target.half_size_um = {Um(cavity.half_x_m), Um(cavity.half_y_m), 0};
  out.exercise.target.depth_um = Um(cavity.depth_m);
  out.exercise.target.leeway_side_um = 200;
  out.exercise.target.leeway_bottom_um = 100;
  out.exercise.target.container_um = 500;
  return out;
}

double Found(const scoring::MetricSet& metrics, std::string_view name) {
  for (const scoring::MetricValue& m : metrics.values)
    if (m.name == name) return m.value;
  return std::nan("");
}

// The cavity with a wall moved and the floor lowered, and the cavity with a leaning wall.
BoxCavity Larger() {
  BoxCavity out = FaultBlockCavity();
  out.faces[0].moved_m = kWall_m;
  out.faces[4].moved_m = kFloor_m;
  return out;
}
BoxCavity Leaning() {
  BoxCavity out = FaultBlockCavity();
  out.faces[0].slope = std::tan(kLean_deg * std::numbers::pi / 180);
  return out;
}

// What is cut in excess by the larger one.
double Excess_mm3() {
  const BoxCavity c = FaultBlockCavity();
  const double width = 2 * c.half_y_m, length = 2 * c.half_x_m;
  return 1e9 * width * ((length + kWall_m) * (c.depth_m + kFloor_m) - length * c.depth_m);
}

struct Errors {
  double wall_um, floor_um, lean_deg, volume_percent;
};

Errors ErrorsOn(int32_t voxel_nm, double grid_at) {
  const BlockTask task = MakeBlockTask();
  const cutting::Volume block = FaultBlock({voxel_nm, grid_at * voxel_nm * 1e-9});
  const scoring::ProcessRecorder calm = scoring::CalmRecording();
  struct Filled {
    cutting::Volume volume;
    surface::Mesh mesh;
  };
  auto Fill = [&](const BoxCavity& cavity) {
    Filled out;
    out.volume = CutAway(
        block, Turned([cavity](const dvec3& p) { return cavity.Distance_m(p); }, kTurn_deg));
    out.mesh = surface::ExtractSurface(out.volume);
    return out;
  };
  scoring::MetricPlan plan;
  plan.Add(scoring::MetricGroup::kTask);
  plan.Add(scoring::MetricGroup::kWalls);
  const Filled reference = Fill(FaultBlockCavity());
  auto Measure = [&](const BoxCavity& cavity) {
    const Filled made = Fill(cavity);
    auto metrics = scoring::ComputeMetrics(
        task.scene, task.exercise, {&block, &made.volume, &made.mesh, &calm},
        {&block, &reference.volume, &reference.mesh, nullptr}, {}, plan);
    ENAMEL_CHECK(metrics.ok());
    return std::move(*metrics);
  };
  const scoring::MetricSet larger = Measure(Larger()), leaning = Measure(Leaning());
  const double excess = Found(larger, "overcut_mm3") + Found(larger, "outside_removed_mm3");
  return {1e3 * Found(larger, "wall_mesial_mm") - 1e6 * kWall_m,
          1e3 * Found(larger, "floor_mm") - 1e6 * kFloor_m,
          Found(leaning, "tilt_mesial_deg") - kLean_deg, 100 * (excess / Excess_mm3() - 1)};
}

}  // namespace

std::vector<OrderRow> ScoreOrders(bool quick, int threads) {
  std::vector<int32_t> voxels_nm = {200'000, 100'000};
  if (!quick) voxels_nm.push_back(50'000);
  std::vector<Errors> found(voxels_nm.size() * kGrids);
  ParallelFor(found.size(), threads, [&](size_t i) {
    found[i] = ErrorsOn(voxels_nm[i / kGrids], static_cast<double>(i % kGrids) / kGrids);
  });
  struct Figure {
    const char *quantity, *unit;
    double Errors::*of;
  };
  std::vector<OrderRow> out;
  for (const Figure& f : {Figure{"wall offset", "um", &Errors::wall_um},
                          Figure{"floor depth", "um", &Errors::floor_um},
                          Figure{"wall angle", "deg", &Errors::lean_deg},
                          Figure{"volume", "%", &Errors::volume_percent}}) {
    std::vector<StepErrors> errors;
    for (size_t v = 0; v < voxels_nm.size(); ++v) {
      errors.push_back({voxels_nm[v] * 1e-6, {}});
      for (size_t g = 0; g < kGrids; ++g)
        errors.back().errors.push_back(found[v * kGrids + g].*f.of);
    }
    OrderRow row;
    row.method = "scores";
    row.what = "box 3 x 2.4 x 2 mm, turned";
    row.quantity = f.quantity;
    row.unit = f.unit;
    row.step_unit = "mm";
    out.push_back(OrderRowOf(std::move(row), errors));
  }
  return out;
}

}  // namespace enamel::station::lab
