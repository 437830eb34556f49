#include "common/scoring/deviation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/scoring/metrics.h"

namespace enamel::scoring {
namespace {

using cutting::Volume;

// Far above the 1/8192 voxel that a sample's rounding leaves, far below any wanted cut.
constexpr double kCutVoxels = 0.1;
constexpr double kFacing = 0.9;
constexpr double kLineStepVoxels = 0.5;
// Positions are single precision: 0.5 nm at 5 mm. A smaller distance counts as 0.
constexpr double kPositionResolution_m = 1e-9;

// Nearly all distances are smaller than this.
constexpr double kUsual_m = 0.6e-3;

// Distances of given points to a surface. A cut is a small part of a tooth, and so is the surface
// around it: the rest is taken in only when a point is far from that.
class DistanceFrom {
 public:
  DistanceFrom(const surface::Mesh& mesh, const dvec3& lo_m, const dvec3& hi_m)
      : mesh_(mesh), around_(mesh, lo_m - kUsual_m, hi_m + kUsual_m) {}
  // Requires: a point between lo_m and hi_m.
  double Distance_m(const dvec3& point_m, double limit_m) {
    const double usual = around_.Distance_m(point_m, std::min(limit_m, kUsual_m));
    // A triangle nearer than kUsual_m meets the box.
    if (usual < kUsual_m || limit_m <= kUsual_m) return usual;
    if (!all_) all_.emplace(mesh_);
    return all_->Distance_m(point_m, limit_m);
  }

 private:
  const surface::Mesh& mesh_;
  const surface::DistanceQuery around_;
  std::optional<surface::DistanceQuery> all_;
};

}  // namespace

bool IsCut(const Volume& initial, const Volume& after, const dvec3& point_m) {
  return after.DistanceAt_m(point_m) - initial.DistanceAt_m(point_m) >
         kCutVoxels * initial.spec().voxel_m();
}

std::vector<float> DeviationPerVertex(const surface::Mesh& mesh, const Volume& initial,
                                      const Volume& final_volume, const Volume& reference,
                                      const surface::Mesh& reference_surface) {
  std::vector<float> out(mesh.position_m.size(), std::numeric_limits<float>::quiet_NaN());
  const CutTest cut(initial, final_volume), wanted(initial, reference);
  std::vector<size_t> asked;
  dvec3 lo(std::numeric_limits<double>::infinity()), hi = -lo;
  for (size_t i = 0; i < out.size(); ++i) {
    const dvec3 p(mesh.position_m[i]);
    if (!cut.At(p) && !wanted.At(p)) continue;
    asked.push_back(i);
    lo = glm::min(lo, p), hi = glm::max(hi, p);
  }
  if (asked.empty()) return out;
  DistanceFrom query(reference_surface, lo, hi);
  double last = kDeviationLimit_m;
  dvec3 last_at(0);
  for (size_t i : asked) {
    const dvec3 p(mesh.position_m[i]);
    // From the triangles: a volume's own distance ends at four voxels. The volume gives the side
    // alone.
    // Vertices follow each other closely, and a distance changes by no more than the way: what is
    // farther need not be looked at. Wider by more than rounding, so that no answer changes.
    const double way = std::sqrt(Dot(p - last_at, p - last_at));
    double distance = query.Distance_m(
        p, std::min(kDeviationLimit_m, (last + way) * (1 + 1e-9) + kPositionResolution_m));
    last = distance;
    last_at = p;
    if (distance < kPositionResolution_m) distance = 0;
    bool in_reference_solid = reference.DistanceAt_m(p) < 0;
    out[i] = static_cast<float>(in_reference_solid || distance == 0 ? distance : -distance);
  }
  return out;
}

double SurfaceAlong_m(const Volume& volume, const dvec3& point_m, const dvec3& direction,
                      double limit_m) {
  double here = volume.DistanceAt_m(point_m);
  double sign = here < 0 ? 1 : -1;
  double step = kLineStepVoxels * volume.spec().voxel_m();
  for (double from = 0; from < limit_m; from += step) {
    double next = volume.DistanceAt_m(point_m + direction * (sign * (from + step)));
    if ((next < 0) == (here < 0)) {
      here = next;
      continue;
    }
    // Between two samples of opposite sign the distance is taken as linear, as everywhere else.
    return sign * std::min(limit_m, from + step * (here / (here - next)));
  }
  return sign * limit_m;
}

double WeightedQuantile(std::vector<WeightedValue> values, double share) {
  // By weight too: equal values in another order would add up to other last bits.
  std::sort(values.begin(), values.end(), [](const WeightedValue& a, const WeightedValue& b) {
    return a.value != b.value ? a.value < b.value : a.weight < b.weight;
  });
  double total = 0;
  for (const WeightedValue& v : values) total += v.weight;
  double sum = 0;
  for (const WeightedValue& v : values) {
    sum += v.weight;
    if (sum >= share * total) return v.value;
  }
  return values.empty() ? 0 : values.back().value;
}

std::vector<double> VertexAreas_m2(const surface::Mesh& mesh) {
  std::vector<double> areas(mesh.position_m.size());
  for (const auto& t : mesh.triangles) {
    dvec3 a(mesh.position_m[t[0]]);
    dvec3 normal = glm::cross(dvec3(mesh.position_m[t[1]]) - a, dvec3(mesh.position_m[t[2]]) - a);
    double third = std::sqrt(Dot(normal, normal)) / 6;
    for (uint32_t v : t) areas[v] += third;
  }
  return areas;
}

Part PartOf(const OpenBox& target, double depth_m, const dvec3& point_m, const dvec3& normal) {
  dvec3 middle = (target.lo_m + target.hi_m) * 0.5;
  dvec3 half = (target.hi_m - target.lo_m) * 0.5;
  dvec3 out = point_m - middle;
  bool in_length = std::fabs(out.x) <= half.x, in_width = std::fabs(out.y) <= half.y;
  if (normal.z >= kFacing) {
    bool low = point_m.z <= target.lo_m.z + 0.5 * depth_m;
    return low && in_length && in_width ? kFloor : kNoPart;
  }
  // A normal points into the air, so the wall at +x faces -x.
  const double faces = target.mesial_x * normal.x, mesially = target.mesial_x * out.x;
  if (in_width && faces <= -kFacing && mesially > 0.5 * half.x) return kMesial;
  if (in_width && faces >= kFacing && mesially < -0.5 * half.x) return kDistal;
  if (in_length && normal.y <= -kFacing && out.y > 0.5 * half.y) return kBuccal;
  if (in_length && normal.y >= kFacing && out.y < -0.5 * half.y) return kLingual;
  return kNoPart;
}

}  // namespace enamel::scoring
