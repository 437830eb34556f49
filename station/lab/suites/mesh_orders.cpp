#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/scene/builder.h"
#include "common/surface/surface.h"
#include "station/lab/suites/orders.h"

namespace enamel::station::lab {
namespace {

constexpr double kRadius_m = 1e-3;
constexpr size_t kGrids = 8;
// Along no axis and no plane of symmetry of the grid.
const dvec3 kView = glm::normalize(dvec3(1, 2, 3));

cutting::Volume SphereOn(int32_t voxel_nm, const dvec3& grid_at) {
  cutting::GridSpec grid = scene::GridAround(dvec3(-kRadius_m), dvec3(kRadius_m), voxel_nm);
  for (int i = 0; i < 3; ++i)
    grid.origin_nm[static_cast<size_t>(i)] -= std::llround(grid_at[i] * voxel_nm);
  return scene::BuildVolume(
      grid,
      [](const dvec3& p) {
        return scene::FieldSample{std::sqrt(Dot(p, p)) - kRadius_m, cutting::Tissue::kGypsum, 1.0};
      },
      scene::BuildThreads());
}

double DistanceRms_um(const surface::Mesh& mesh) {
  std::vector<double> off;
  for (const glm::vec3& at : mesh.position_m)
    off.push_back(1e6 * (glm::length(dvec3(at)) - kRadius_m));
  return Rms(off);
}

double VolumeError_percent(const surface::Mesh& mesh) {
  const double ball_m3 = 4.0 / 3 * std::numbers::pi * kRadius_m * kRadius_m * kRadius_m;
  return 100 * (surface::EnclosedVolume_m3(mesh) / ball_m3 - 1);
}

// How far the outline lies from the sphere's, on rays from the middle. The outline on a ray is the farthest edge that
// crosses it, whether its triangles face the viewer or not.
double OutlineRms_um(const surface::Mesh& mesh) {
  constexpr int kRays = 720;
  constexpr double kStep = 2 * std::numbers::pi / kRays;
  const dvec3 across = glm::normalize(glm::cross(kView, dvec3(0, 0, 1)));
  const dvec3 up = glm::cross(kView, across);
  std::vector<glm::dvec2> seen;
  for (const glm::vec3& at : mesh.position_m)
    seen.emplace_back(Dot(dvec3(at), across), Dot(dvec3(at), up));
  auto Cross = [](const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; };
  std::vector<double> farthest(kRays, 0);
  auto Edge = [&](glm::dvec2 p, glm::dvec2 q) {
    // Inside the outline for certain; and an edge across the middle would cross half of all rays.
    if (std::max(glm::length(p), glm::length(q)) < 0.9 * kRadius_m) return;
    if (Cross(p, q) < 0) std::swap(p, q);
    const double from = std::atan2(p.y, p.x), turn = std::atan2(Cross(p, q), glm::dot(p, q));
    for (int k = static_cast<int>(std::ceil(from / kStep)); k * kStep <= from + turn; ++k) {
      const glm::dvec2 ray(std::cos(k * kStep), std::sin(k * kStep));
      const double across_ray = Cross(ray, q - p);
      if (across_ray == 0) continue;
      double& far = farthest[static_cast<size_t>((k + kRays) % kRays)];
      far = std::max(far, Cross(p, q) / across_ray);
    }
  };
  for (const auto& t : mesh.triangles)
    for (size_t i = 0; i < 3; ++i) Edge(seen[t[i]], seen[t[(i + 1) % 3]]);
  for (double& far : farthest) far = 1e6 * (far - kRadius_m);
  return Rms(farthest);
}

}  // namespace

std::vector<OrderRow> MeshOrders(bool quick) {
  struct Figure {
    const char *method, *quantity, *unit;
    double (*of)(const surface::Mesh&);
    std::vector<StepErrors> errors{};
  };
  Figure figures[] = {{"meshes", "surface", "um", &DistanceRms_um},
                      {"meshes", "volume", "%", &VolumeError_percent},
                      {"pictures", "outline", "um", &OutlineRms_um}};
  std::vector<int32_t> voxels_nm = {200'000, 100'000, 50'000};
  if (!quick) voxels_nm.push_back(25'000);
  for (int32_t voxel_nm : voxels_nm) {
    for (Figure& f : figures) f.errors.push_back({voxel_nm * 1e-6, {}});
    for (size_t i = 0; i < kGrids; ++i) {
      const surface::Mesh mesh = surface::ExtractSurface(SphereOn(voxel_nm, GridAt(i)));
      for (Figure& f : figures) f.errors.back().errors.push_back(f.of(mesh));
    }
  }
  std::vector<OrderRow> out;
  for (const Figure& f : figures) {
    OrderRow row;
    row.method = f.method;
    row.what = "sphere r 1 mm";
    row.quantity = f.quantity;
    row.unit = f.unit;
    row.step_unit = "mm";
    out.push_back(OrderRowOf(std::move(row), f.errors));
  }
  return out;
}

}  // namespace enamel::station::lab
