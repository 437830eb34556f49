#include "station/desk/watch/reach_watch.h"

#include <algorithm>
#include <cmath>

namespace enamel::station::desk {
namespace {

using cutting::GridSpec;
using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::Tissue;
using cutting::Volume;

// Greater distances beyond a hollow are reported as this.
constexpr double kFar_m = 5e-3;

ivec3 FirstVoxel(const GridSpec& spec, int brick) {
  return ivec3(brick % spec.bricks.x, brick / spec.bricks.x % spec.bricks.y,
               brick / (spec.bricks.x * spec.bricks.y)) *
         kBrickSide;
}

// kBrickSide is 8, x fastest.
ivec3 InBrick(int i) { return {i & 7, i >> 3 & 7, i >> 6}; }

dvec3 At_m(const GridSpec& spec, const dvec3& voxel) {
  return spec.origin_m() + voxel * spec.voxel_m();
}

double HalfBrick_m(const GridSpec& spec) { return 0.5 * kBrickSide * spec.voxel_m(); }

dvec3 Middle_m(const GridSpec& spec, int brick) {
  return At_m(spec, dvec3(FirstVoxel(spec, brick)) + 0.5 * (kBrickSide - 1));
}

bool IsPulp(const Volume& volume, const ivec3& voxel) {
  return volume.TissueAt(voxel) == Tissue::kPulp && volume.PhiAt(voxel) < 0;
}

bool HasPulp(const Volume& volume, int brick) {
  if (!volume.HasLabels(brick)) return volume.UniformTissue(brick) == Tissue::kPulp;
  const auto& labels = volume.Labels(brick).tissue;
  return std::find(labels.begin(), labels.end(), static_cast<uint8_t>(Tissue::kPulp)) !=
         labels.end();
}

// Bricks with pulp and those around them, once each, in order.
std::vector<int> BricksAroundPulp(const Volume& volume) {
  const GridSpec& spec = volume.spec();
  std::vector<int> out;
  for (int b = 0; b < spec.brick_count(); ++b) {
    if (!HasPulp(volume, b)) continue;
    ivec3 here = FirstVoxel(spec, b) / kBrickSide;
    for (int i = 0; i < 27; ++i) {
      ivec3 beside = here + ivec3(i % 3, i / 3 % 3, i / 9) - 1;
      if (spec.Contains(beside)) out.push_back(spec.BrickIndex(beside));
    }
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// Only the pulp, its surface half-way between its voxels and the others.
Volume PulpAlone(const Volume& volume, const std::vector<int>& bricks) {
  Volume pulp(volume.spec());
  for (int b : bricks) {
    ivec3 first = FirstVoxel(volume.spec(), b);
    std::array<int16_t, kBrickVoxels> phi;
    for (int i = 0; i < kBrickVoxels; ++i) {
      bool inside = IsPulp(volume, first + InBrick(i));
      phi[static_cast<size_t>(i)] = (inside ? -1 : 1) * cutting::kPhiPerVoxel / 2;
    }
    pulp.SetBrick(b, phi, {}, Tissue::kPulp);
  }
  return pulp;
}

// Calls visit(point in m, voxel) wherever original solid in this brick now ends: the voxel was
// removed, the point is between it and a remaining one.
template <typename Visit>
void ForEachCutPoint(const Volume& initial, const Volume& now, int brick, Visit&& visit) {
  const GridSpec& spec = now.spec();
  ivec3 first = FirstVoxel(spec, brick);
  const auto& phi = now.Phi(brick).phi;
  for (int i = 0; i < kBrickVoxels; ++i) {
    int here = phi[static_cast<size_t>(i)];
    ivec3 voxel = first + InBrick(i);
    if (here < 0 || initial.PhiAt(voxel) >= 0) continue;
    for (int side = 0; side < 6; ++side) {
      ivec3 step(0);
      step[side / 2] = side % 2 == 0 ? 1 : -1;
      int beside = now.PhiAt(voxel + step);
      if (beside >= 0) continue;
      // Where the distance crosses 0 between the two, taken as linear.
      double share = static_cast<double>(here) / (here - beside);
      visit(At_m(spec, dvec3(voxel) + share * dvec3(step)), voxel);
    }
  }
}

}  // namespace

ReachWatch::ReachWatch(const scene::Scene& scene, const scene::CavityTarget& target,
                       const Volume& initial)
    : initial_(initial), pulp_m_(render::kPulpFar_mm * 1e-3) {
  auto boxes = scoring::BoxesOf(scene, target);
  if (!boxes.ok() || target.depth_um == 0) return;
  if (boxes->shape || boxes->prepared) {
    shape_ = boxes->shape;
    prepared_ = boxes->prepared;
    shape_leeway_m_ = std::min(target.leeway_side_um, target.leeway_bottom_um) * 1e-6;
    Publish();
    return;
  }
  const scoring::OpenBox& box = boxes->target;
  double beside = target.leeway_side_um * 1e-6, below = target.leeway_bottom_um * 1e-6;
  const bool to_right = box.mesial_x > 0;
  sides_ = {
      {to_right ? "reach.mesial_wall" : "reach.distal_wall", {1, 0, 0}, box.hi_m.x, beside, 0},
      {to_right ? "reach.distal_wall" : "reach.mesial_wall", {-1, 0, 0}, -box.lo_m.x, beside, 0},
      {"reach.buccal_wall", {0, 1, 0}, box.hi_m.y, beside, 0},
      {"reach.lingual_wall", {0, -1, 0}, -box.lo_m.y, beside, 0},
      {"reach.floor", {0, 0, -1}, -box.lo_m.z, below, 0}};
  Publish();
}

ReachWatch::~ReachWatch() = default;

double ReachWatch::BeyondShape_m(const dvec3& p_m) const {
  return hollow_ ? hollow_->Distance_m(p_m, kFar_m) : scene::PreparationDistance_m(*shape_, p_m);
}

bool ReachWatch::MayGoFarther(const dvec3& middle_m) const {
  // Points of a brick's voxels reach a voxel beyond them.
  double half = HalfBrick_m(initial_.spec()) + initial_.spec().voxel_m();
  // For the middle of a brick that may be air, the side in a hollow is unknown.
  if (hollow_) return hollow_->ToCut_m(middle_m, kFar_m) + std::sqrt(3.0) * half > beyond_shape_m_;
  if (shape_) return BeyondShape_m(middle_m) + std::sqrt(3.0) * half > beyond_shape_m_;
  return std::any_of(sides_.begin(), sides_.end(), [&](const Side& side) {
    return Dot(middle_m, side.outward) + half - side.at_m > side.beyond_m;
  });
}

bool ReachWatch::MayBeNearerPulp(int brick, const dvec3& middle_m) {
  double corner = std::sqrt(3.0) * (HalfBrick_m(initial_.spec()) + initial_.spec().voxel_m());
  float& bound = pulp_bound_m_[static_cast<size_t>(brick)];
  // The distance changes by no more than a point moves, so the middle's, less the half diagonal,
  // bounds every point of the brick. Computed once, since the pulp keeps its original surface.
  if (bound < 0) {
    bound =
        static_cast<float>(std::max(0.0, pulp_->Distance_m(middle_m, pulp_m_ + corner) - corner));
  }
  return static_cast<double>(bound) < pulp_m_;
}

void ReachWatch::LookAtBrick(const Volume& now, int brick) {
  dvec3 middle = Middle_m(now.spec(), brick);
  bool farther = MayGoFarther(middle), nearer = pulp_ && MayBeNearerPulp(brick, middle);
  if (!farther && !nearer) return;
  ForEachCutPoint(initial_, now, brick, [&](const dvec3& p, const ivec3& voxel) {
    for (Side& side : sides_) {
      side.beyond_m = std::max(side.beyond_m, Dot(p, side.outward) - side.at_m);
    }
    if (FollowsShape()) LookBeyondShape(p);
    if (nearer) pulp_m_ = IsPulp(initial_, voxel) ? 0 : pulp_->Distance_m(p, pulp_m_);
  });
}

// Below the floor the way up leads back to the shape; beside a wall it does not.
void ReachWatch::LookBeyondShape(const dvec3& p_m) {
  const double beyond = BeyondShape_m(p_m);
  if (beyond <= beyond_shape_m_) return;
  beyond_shape_m_ = beyond;
  below_shape_ = BeyondShape_m(p_m + dvec3(0, 0, beyond)) < 0.5 * beyond;
}

void ReachWatch::Look(const Volume& now) {
  if (!pulp_looked_for_) {
    pulp_looked_for_ = true;
    std::vector<int> bricks = BricksAroundPulp(initial_);
    if (!bricks.empty()) {
      pulp_ = std::make_unique<surface::DistanceQuery>(
          surface::ExtractSurface(PulpAlone(initial_, bricks)));
      pulp_bound_m_.assign(static_cast<size_t>(initial_.spec().brick_count()), -1);
    }
  }
  if (prepared_ && !hollow_)
    hollow_ = std::make_unique<scoring::Hollow>(initial_, prepared_->volume);
  for (int b = 0; b < now.spec().brick_count(); ++b) {
    if (!now.IsStored(b)) continue;
    // Uncut bricks are recognised by their samples, so no list of touched ones is kept.
    if (initial_.IsStored(b) && initial_.Phi(b).phi == now.Phi(b).phi) continue;
    LookAtBrick(now, b);
  }
  Publish();
}

void ReachWatch::Publish() {
  render::Reach out;
  if (pulp_) out.pulp_mm = pulp_m_ * 1e3;
  if (FollowsShape()) {
    out.leeway = {{1e3 * (shape_leeway_m_ - beyond_shape_m_), 1e3 * shape_leeway_m_,
                   beyond_shape_m_ <= 0 ? ""
                   : below_shape_       ? "reach.floor"
                                        : "reach.outline"}};
  }
  if (!sides_.empty()) {
    // A leeway of nothing is used up by the least excess.
    auto used = [](const Side& s) { return s.beyond_m / std::max(s.leeway_m, 1e-9); };
    auto nearest =
        std::max_element(sides_.begin(), sides_.end(),
                         [&](const Side& a, const Side& b) { return used(a) < used(b); });
    out.leeway = {{1e3 * (nearest->leeway_m - nearest->beyond_m), 1e3 * nearest->leeway_m,
                   nearest->beyond_m > 0 ? nearest->name : ""}};
  }
  MutexLock lock(mutex_);
  reach_ = out;
}

render::Reach ReachWatch::reach() const {
  MutexLock lock(mutex_);
  return reach_;
}

}  // namespace enamel::station::desk
