#include <algorithm>
#include <array>
#include <cmath>

#include "common/surface/surface.h"

namespace enamel::surface {
namespace {

using cutting::kPhiPerVoxel;

// A cubic B-spline at `p` between the middle two of four samples: the weight of each sample, and the
// derivative of that weight by p.
struct Spline {
  std::array<double, 4> weight, slope;
};
Spline SplineAt(double p) {
  const double q = 1 - p;
  return {
      {q * q * q / 6, 2.0 / 3 - p * p * (1 - p / 2), 2.0 / 3 - q * q * (1 - q / 2), p * p * p / 6},
      {-q * q / 2, p * (1.5 * p - 2), q * (2 - 1.5 * q), p * p / 2}};
}

}  // namespace

glm::vec3 SmoothNormal(const cutting::Volume& volume, const dvec3& sample,
                       const glm::vec3& otherwise) {
  const dvec3 cell = glm::floor(sample);
  const Spline x = SplineAt(sample.x - cell.x), y = SplineAt(sample.y - cell.y),
               z = SplineAt(sample.z - cell.z);
  const ivec3 first = ivec3(cell) - 1;
  dvec3 gradient(0);
  for (size_t k = 0; k < 4; ++k) {
    for (size_t j = 0; j < 4; ++j) {
      double value = 0, slope = 0;
      for (size_t i = 0; i < 4; ++i) {
        const double phi =
            std::clamp(volume.PhiAt(first + ivec3(i, j, k)), -kPhiPerVoxel, kPhiPerVoxel);
        value += phi * x.weight[i];
        slope += phi * x.slope[i];
      }
      gradient.x += slope * y.weight[j] * z.weight[k];
      gradient.y += value * y.slope[j] * z.weight[k];
      gradient.z += value * y.weight[j] * z.slope[k];
    }
  }
  const double length = glm::length(gradient);
  // In the middle of a thin sheet the direction is rounding, not shape.
  return length > 0.05 * kPhiPerVoxel ? glm::vec3(gradient / length) : otherwise;
}

std::vector<glm::vec3> SmoothNormals(const cutting::Volume& volume, const Mesh& mesh) {
  const cutting::GridSpec& spec = volume.spec();
  std::vector<glm::vec3> out;
  out.reserve(mesh.normal.size());
  for (size_t v = 0; v < mesh.normal.size(); ++v) {
    const dvec3 sample = (dvec3(mesh.position_m[v]) - spec.origin_m()) / spec.voxel_m();
    out.push_back(SmoothNormal(volume, sample, mesh.normal[v]));
  }
  return out;
}

}  // namespace enamel::surface
