#include "common/scoring/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/trig.h"

namespace enamel::scoring {
namespace {

using cutting::Tissue;
using cutting::Volume;

constexpr double kPatch_m2 = 0.02e-6;    // what a bur's tip leaves at the least
constexpr double kMinWall_m2 = 0.05e-6;  // smaller faces belong to edges
// And of the target's face: what stands where a box ends in the open is a flake, no wall.
constexpr double kMinOfFace = 0.1;
// The longest line, in units of the largest nearest distance of the wall.
constexpr double kOtherSurface = 2;
// The shares of a wall or floor that must be there before it is begun, and before it has a lean: a
// cavity that is too small all round meets two thirds of each.
constexpr double kBegunShare = 0.3, kMadeShare = 0.5;
// A place on a wall counts at most this much in its waviness: deepest_over_mm measures the depth of
// a gouge.
constexpr double kMaxWave_m = 0.3e-3;
constexpr double kDeepest_m = 8e-3;  // no floor of a cavity lies deeper
constexpr double kFitFrom = 0.15, kFitTo = 0.9;
constexpr double kDegrees = 180 / 3.14159265358979323846;

// The largest value that is reached by `area_m2` of the weight; 0 where none is.
double ReachedBy(std::vector<WeightedValue> values, double area_m2) {
  std::sort(values.begin(), values.end(), [](const WeightedValue& a, const WeightedValue& b) {
    return a.value != b.value ? a.value > b.value : a.weight < b.weight;
  });
  double sum = 0;
  for (const WeightedValue& v : values) {
    sum += v.weight;
    if (sum >= area_m2) return v.value;
  }
  return 0;
}

double Length(const dvec3& v) { return std::sqrt(Dot(v, v)); }

// Part by part: its vertices on the reference and their mean normal.
struct WallPatch {
  std::vector<size_t> vertices;
  dvec3 normal{0};
  double area_m2 = 0;
};

std::array<WallPatch, kPartCount> PatchesOf(const CutSide& reference, const OpenBox& target,
                                            double depth_m) {
  std::array<WallPatch, kPartCount> patches;
  const surface::Mesh& mesh = *reference.mesh;
  for (size_t i = 0; i < mesh.position_m.size(); ++i) {
    if (!(*reference.cut)[i]) continue;
    const dvec3 facing(mesh.normal[i]);
    const Part part = PartOf(target, depth_m, dvec3(mesh.position_m[i]), facing);
    if (part == kNoPart) continue;
    const double area = (*reference.areas_m2)[i];
    patches[part].vertices.push_back(i);
    patches[part].normal += facing * area;
    patches[part].area_m2 += area;
  }
  for (WallPatch& p : patches) {
    if (const double length = Length(p.normal); length > 0) p.normal /= length;
  }
  return patches;
}

// How far a wall opens towards the top: its mean normal is turned by the rounded vertices of its
// edges, so that a plane through its own vertices corrects it.
double OpensDegrees(const dvec3& normal, std::vector<Height> own) {
  const double across = std::sqrt(normal.x * normal.x + normal.y * normal.y);
  return kDegrees * (ArcTan(normal.z / across) + ArcTan(FitPlaneToMost(own, 0).b));
}

// A plane over the wall's own directions, in the scene.
Facet FacetOf(const Plane& plane, const dvec3& normal, const dvec3& up, const dvec3& along) {
  const dvec3 n = normal + plane.b * up + plane.c * along;
  const double length = Length(n);
  return {n / length, (plane.b * plane.s0 + plane.c * plane.t0 - plane.d0) / length};
}

// Drops a tenth at each side: the round edge beside a wall that is wavy, or a little short, is not
// a wave of this one.
void KeepInner(std::vector<Height>& heights, std::initializer_list<double Height::*> ways) {
  constexpr double kMargin = 0.1;
  for (double Height::*way : ways) {
    if (heights.empty()) return;
    double from = heights.front().*way, to = from;
    for (const Height& h : heights) from = std::min(from, h.*way), to = std::max(to, h.*way);
    const double margin = kMargin * (to - from);
    std::erase_if(heights,
                  [&](const Height& h) { return h.*way < from + margin || h.*way > to - margin; });
  }
}

// The surface there stands upright on the wall, or nearly: it is another's, no part of this one. A
// wave as steep as voxels can show still faces as its wall does.
bool IsBeside(const Volume& volume, const dvec3& at_m, const dvec3& normal) {
  constexpr double kMinFacing = 0.3;
  const dvec3 slope =
      volume.SlopeAtSample((at_m - volume.spec().origin_m()) / volume.spec().voxel_m());
  return Dot(slope, normal) < kMinFacing * Length(slope);
}

double FaceArea_m2(const OpenBox& target, double depth_m, size_t part) {
  const double x = target.hi_m.x - target.lo_m.x, y = target.hi_m.y - target.lo_m.y;
  if (part == kFloor) return x * y;
  return depth_m * (part == kMesial || part == kDistal ? y : x);
}

WallFigures MeasureWall(const Volume& initial, const CutSide& attempt, const CutSide& reference,
                        const WallPatch& patch, const std::vector<float>& deviation_m,
                        double least_m2, bool floor) {
  WallFigures out;
  out.in_task = patch.area_m2 >= least_m2;
  if (!out.in_task) return out;
  const double h = attempt.volume->spec().voxel_m();
  // In the wall's plane: up it (along x on a floor), and along it.
  dvec3 up = floor ? dvec3(1, 0, 0) : dvec3(0, 0, 1);
  up -= patch.normal * Dot(up, patch.normal);
  up /= Length(up);
  const dvec3 along = glm::cross(up, patch.normal);

  std::vector<WeightedValue> offsets;
  // The attempt over the reference; the reference's surface; the attempt's surface.
  std::vector<Height> heights, own_heights, made_heights;
  double met_m2 = 0, untouched_m2 = 0, pit_m2 = 0, lowest = std::numeric_limits<double>::infinity(),
         highest = -lowest;
  // Nearest distances to a rough wall end at whatever sticks out of it; along one direction they
  // are the two walls' heights. A surface much farther along the line is another one. The limit is
  // the whole wall's: beside an edge the next wall is near, however far this one has moved.
  double most = 0;
  for (size_t i : patch.vertices) most = std::max(most, std::fabs(double{deviation_m[i]}));
  const double reach = kOtherSurface * most + h;
  for (size_t i : patch.vertices) {
    const dvec3 p(reference.mesh->position_m[i]);
    const double area = (*reference.areas_m2)[i], nearest = deviation_m[i];
    // Over and under a floor there is one surface, however far; the nearest may be a side that is
    // open, or of a pit.
    const bool left = attempt.volume->DistanceAt_m(p) < 0;
    const double limit = floor ? std::max(reach, kDeepest_m) : reach;
    const double there = SurfaceAlong_m(*attempt.volume, p, patch.normal, limit);
    const bool met = std::fabs(there) < limit;
    // The tooth's own surface, behind which nothing was cut yet, is no wall and no floor.
    const bool cut = met && IsCut(initial, *attempt.volume, p + patch.normal * there);
    if (left && !cut) untouched_m2 += area;
    if (!met) {
      // The floor goes out of the tooth.
      if (floor && !left) pit_m2 += area;
      offsets.push_back({-nearest, area});
      continue;
    }
    if (left && !cut) {
      offsets.push_back({-there, area});
      continue;
    }
    met_m2 += area;
    // Where a wall that is short stands on the floor, the line meets its foot.
    if (IsBeside(*attempt.volume, p + patch.normal * there, patch.normal)) {
      offsets.push_back({-there, area});
      continue;
    }
    const double own = SurfaceAlong_m(*reference.volume, p, patch.normal, h);
    Height height{own - there, area, Dot(p, up), Dot(p, along)};
    lowest = std::min(lowest, height.s), highest = std::max(highest, height.s);
    offsets.push_back({height.d, area});
    heights.push_back(height);
    own_heights.push_back({-Dot(p, patch.normal), area, height.s, height.t});
    made_heights.push_back({-Dot(p, patch.normal) - there, area, height.s, height.t});
  }
  out.offset_m = WeightedQuantile(std::move(offsets), 0.5) + 0.0;  // -0 becomes 0
  out.begun = untouched_m2 < (1 - kBegunShare) * patch.area_m2;
  out.made = met_m2 >= kMadeShare * patch.area_m2;
  if (!out.made) return out;

  const double from = lowest + kFitFrom * (highest - lowest);
  const double to = lowest + kFitTo * (highest - lowest);
  auto at_edge = [&](const Height& q) { return q.s < from || q.s > to; };
  if (!floor) {
    for (auto* list : {&heights, &own_heights, &made_heights}) std::erase_if(*list, at_edge);
  }
  std::vector<Height> most_heights = heights;
  const Plane plane = FitPlaneToMost(most_heights, 0.25 * h);
  out.facet = FacetOf(FitPlaneToMost(made_heights, 0.25 * h), patch.normal, up, along);
  double squares = pit_m2 * kMaxWave_m * kMaxWave_m, area = pit_m2;
  // A wall's foot and rim were dropped before.
  floor ? KeepInner(heights, {&Height::s, &Height::t}) : KeepInner(heights, {&Height::t});
  for (const Height& q : heights) {
    const double rest = std::clamp(q.d - plane.At(q), -kMaxWave_m, kMaxWave_m);
    squares += q.area * rest * rest;
    area += q.area;
  }
  out.waviness_m = area > 0 ? std::sqrt(squares / area) : 0;
  out.over = {
      patch.normal, up, along, plane, lowest, highest, WavesAbout(plane, heights, 0.25 * h)};
  out.tilt_deg =
      kDegrees * ArcTan(floor ? std::sqrt(plane.b * plane.b + plane.c * plane.c) : plane.b);
  out.opens_deg = out.tilt_deg + (floor ? 0 : OpensDegrees(patch.normal, std::move(own_heights)));
  return out;
}

}  // namespace

double Sheet::At_m(const dvec3& point_m) const {
  return plane.At({0, 0, std::clamp(Dot(point_m, up), s_least_m, s_most_m), Dot(point_m, along)});
}

std::vector<dvec3> OutlineOf(const CutSide& side) {
  std::vector<dvec3> out;
  const auto& cut = *side.cut;
  const auto& at = side.mesh->position_m;
  for (const auto& t : side.mesh->triangles) {
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t a = t[k], b = t[(k + 1) % 3];
      // Each edge is in two triangles, once in each direction: taken from the one.
      if (a < b && cut[a] != cut[b]) out.push_back((dvec3(at[a]) + dvec3(at[b])) * 0.5);
    }
  }
  return out;
}

DeviationFigures MeasureDeviation(const CutSide& reference, const std::vector<float>& deviation_m) {
  std::vector<WeightedValue> sizes, left;
  DeviationFigures out;
  double squares = 0, area = 0;
  for (size_t i = 0; i < deviation_m.size(); ++i) {
    if (!(*reference.cut)[i]) continue;
    const double signed_m = deviation_m[i], d = std::fabs(signed_m);
    const double weight = (*reference.areas_m2)[i];
    squares += weight * d * d;
    area += weight;
    sizes.push_back({d, weight});
    if (signed_m > 0) left.push_back({d, weight});
    for (size_t b = 0; b < out.within.size(); ++b) {
      if (d <= DeviationFigures::kBands_m[b]) out.within[b] += weight;
    }
  }
  if (!(area > 0)) return out;
  for (double& share : out.within) share /= area;
  out.rms_m = std::sqrt(squares / area);
  out.p95_m = WeightedQuantile(std::move(sizes), 0.95);
  out.most_left_m = ReachedBy(std::move(left), kPatch_m2);
  return out;
}

Deepest DeepestOver(const CutSide& attempt, const std::vector<float>& deviation_m) {
  std::vector<WeightedValue> over;
  size_t deepest = 0;
  for (size_t i = 0; i < deviation_m.size(); ++i) {
    if (!(deviation_m[i] > 0)) continue;
    over.push_back({deviation_m[i], (*attempt.areas_m2)[i]});
    // The first of equals, so that it is the same everywhere.
    if (!(deviation_m[deepest] >= deviation_m[i])) deepest = i;
  }
  Deepest out;
  if (!over.empty()) out.at_m = dvec3(attempt.mesh->position_m[deepest]);
  out.depth_m = ReachedBy(std::move(over), kPatch_m2);
  return out;
}

Walls MeasureWalls(const Volume& initial, const CutSide& attempt, const CutSide& reference,
                   const std::vector<float>& reference_deviation_m, const OpenBox& target,
                   double depth_m) {
  const auto patches = PatchesOf(reference, target, depth_m);
  Walls out;
  for (size_t p = 0; p < kPartCount; ++p) {
    const double least_m2 = std::max(kMinWall_m2, kMinOfFace * FaceArea_m2(target, depth_m, p));
    out[p] = MeasureWall(initial, attempt, reference, patches[p], reference_deviation_m, least_m2,
                         p == kFloor);
  }
  return out;
}

OutlineFigures MeasureOutline(const Volume& initial, const CutSide& attempt,
                              const CutSide& reference) {
  OutlineFigures out;
  const std::vector<dvec3> wanted = OutlineOf(reference), made = OutlineOf(attempt);
  out.in_task = !wanted.empty();
  out.points = wanted.size();
  if (!out.in_task || made.empty()) return out;
  std::vector<WeightedValue> over, back;
  for (const dvec3& p : wanted) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const dvec3& q : made) nearest = std::min(nearest, Dot(p - q, p - q));
    const double distance = std::sqrt(nearest);
    const bool cut = IsCut(initial, *attempt.volume, p);
    over.push_back({cut ? distance : 0, 1});
    if (cut) out.over_at.push_back({p, distance});
    back.push_back({cut ? 0 : distance, 1});
  }
  out.over_m = WeightedQuantile(std::move(over), 0.95);
  out.short_m = WeightedQuantile(std::move(back), 0.95);
  return out;
}

surface::Mesh PulpSurface(const Volume& initial) {
  // +-half a voxel by the labels, zero between unlike ones.
  const cutting::GridSpec& spec = initial.spec();
  Volume pulp(spec);
  bool any = false;
  for (int b = 0; b < spec.brick_count(); ++b) {
    const auto uniform = initial.UniformTissue(b);
    const uint8_t* labels = initial.HasLabels(b) ? initial.Labels(b).tissue.data() : nullptr;
    if (labels == nullptr) {
      if (uniform != Tissue::kPulp) continue;
      pulp.SetUniform(b, Tissue::kPulp);
      any = true;
      continue;
    }
    std::array<int16_t, cutting::kBrickVoxels> phi;
    bool here = false;
    for (size_t i = 0; i < phi.size(); ++i) {
      const bool is_pulp = labels[i] == static_cast<uint8_t>(Tissue::kPulp);
      phi[i] =
          static_cast<int16_t>(is_pulp ? -cutting::kPhiPerVoxel / 2 : cutting::kPhiPerVoxel / 2);
      here = here || is_pulp;
    }
    if (!here) continue;
    pulp.SetBrick(b, phi, {}, Tissue::kPulp);
    any = true;
  }
  return any ? surface::ExtractSurface(pulp) : surface::Mesh{};
}

RemainingDentin MeasureRemainingDentin(const Volume& initial, const CutSide& attempt,
                                       double limit_m) {
  const surface::Mesh pulp = PulpSurface(initial);
  if (pulp.position_m.empty()) return {limit_m, {}};
  const surface::DistanceQuery query(pulp);
  RemainingDentin out{limit_m, {}};
  for (size_t i = 0; i < attempt.mesh->position_m.size() && out.least_m > 0; ++i) {
    if (!(*attempt.cut)[i]) continue;
    if (attempt.mesh->tissue[i] == static_cast<uint8_t>(Tissue::kPulp)) return {0, i};
    // Limited to the least so far, so that most queries end in a few cells.
    const double away = query.Distance_m(dvec3(attempt.mesh->position_m[i]), out.least_m);
    if (away < out.least_m) out = {away, i};
  }
  return out;
}

}  // namespace enamel::scoring
