#include "station/desk/watch/nearness.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace enamel::station::desk {
namespace {

using cutting::GridSpec;
using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::Tissue;
using cutting::Volume;
using sound::Hazard;

constexpr std::array kHazards = {Hazard::kPulp, Hazard::kNeighbour};

Tissue TissueOf(Hazard hazard) {
  return hazard == Hazard::kPulp ? Tissue::kPulp : Tissue::kNeighbour;
}
double WarnAt_m(Hazard hazard) { return hazard == Hazard::kPulp ? kWarnPulp_m : kWarnNeighbour_m; }

bool Has(const Volume& volume, int brick, Tissue tissue) {
  if (!volume.HasLabels(brick)) return volume.UniformTissue(brick) == tissue;
  return std::ranges::find(volume.Labels(brick).tissue, static_cast<uint8_t>(tissue)) !=
         volume.Labels(brick).tissue.end();
}

bool IsOf(const Volume& volume, const ivec3& voxel, Tissue tissue) {
  return volume.TissueAt(voxel) == tissue && volume.PhiAt(voxel) < 0;
}

// Deep inside of something: nothing of its surface.
bool IsUniform(const Volume& volume, int brick, Tissue tissue) {
  return !volume.IsStored(brick) && volume.UniformTissue(brick) == tissue;
}
bool IsDeep(const Volume& volume, const ivec3& at, Tissue tissue) {
  const GridSpec& spec = volume.spec();
  if (!IsUniform(volume, spec.BrickIndex(at), tissue)) return false;
  for (int side = 0; side < 6; ++side) {
    ivec3 beside = at;
    beside[side / 2] += side % 2 == 0 ? 1 : -1;
    if (!spec.Contains(beside) || !IsUniform(volume, spec.BrickIndex(beside), tissue)) return false;
  }
  return true;
}

bool IsAtSurface(const Volume& volume, const ivec3& voxel, Tissue tissue) {
  for (int side = 0; side < 6; ++side) {
    ivec3 beside = voxel;
    beside[side / 2] += side % 2 == 0 ? 1 : -1;
    if (!IsOf(volume, beside, tissue)) return true;
  }
  return false;
}

}  // namespace

NearnessWatch::NearnessWatch(const std::vector<cutting::Bur>& burs, const Volume& initial)
    : initial_(initial) {
  for (const cutting::Bur& bur : burs) {
    burs_.push_back({cutting::ProfileOf(bur), std::hypot(bur.radius_m, 0.5 * bur.height_m()),
                     dvec3(0, 0, 0.5 * bur.height_m())});
  }
}

void NearnessWatch::AddBrick(int brick) {
  const GridSpec& spec = initial_.spec();
  const ivec3 at(brick % spec.bricks.x, brick / spec.bricks.x % spec.bricks.y,
                 brick / (spec.bricks.x * spec.bricks.y));
  const ivec3 first = at * kBrickSide;
  const double voxel_m = spec.voxel_m();
  for (const Hazard hazard : kHazards) {
    const Tissue tissue = TissueOf(hazard);
    if (!Has(initial_, brick, tissue) || IsDeep(initial_, at, tissue)) continue;
    const size_t begin = points_.size();
    for (int i = 0; i < kBrickVoxels; ++i) {
      const ivec3 voxel = first + ivec3(i & 7, i >> 3 & 7, i >> 6);
      if (!IsOf(initial_, voxel, tissue) || !IsAtSurface(initial_, voxel, tissue)) continue;
      // A tooth's surface is where its distance is 0; a pulp's is half a voxel away.
      const double inside =
          hazard == Hazard::kPulp ? 0.5 : -initial_.PhiAt(voxel) / double{cutting::kPhiPerVoxel};
      points_.push_back({spec.origin_m() + dvec3(voxel) * voxel_m, inside * voxel_m});
    }
    if (points_.size() == begin) continue;
    const double half = 0.5 * (kBrickSide - 1) * voxel_m;
    clusters_.push_back({hazard, spec.origin_m() + dvec3(first) * voxel_m + dvec3(half),
                         std::sqrt(3.0) * half + voxel_m, begin, points_.size()});
  }
}

void NearnessWatch::Look() {
  if (found_.load(std::memory_order_relaxed)) return;
  for (int brick = 0; brick < initial_.spec().brick_count(); ++brick) AddBrick(brick);
  found_.store(true, std::memory_order_release);
}

Warned NearnessWatch::Near(const cutting::Pose& pose, size_t bur) const {
  Warned most;
  if (!found_.load(std::memory_order_acquire)) return most;
  const Body& body = burs_[bur];
  const dmat3 scene_from_bur = pose.orientation.Matrix();
  const dvec3 middle_m = pose.tip_m + scene_from_bur * body.middle_in_bur_m;
  for (const Cluster& cluster : clusters_) {
    const double within = WarnAt_m(cluster.hazard);
    // Balls around both first: of a tooth, most bricks are far away.
    if (glm::length(cluster.middle_m - middle_m) > body.reach_m + cluster.radius_m + within)
      continue;
    for (size_t i = cluster.first; i < cluster.end; ++i) {
      // From the left: by the transpose, which turns back.
      const dvec3 p = (points_[i].at_m - pose.tip_m) * scene_from_bur;
      const double away_m = body.profile.Distance(std::hypot(p.x, p.y), p.z) - points_[i].inside_m;
      const double nearness = std::clamp(1 - away_m / within, 0.0, 1.0);
      if (nearness > most.nearness) most = {cluster.hazard, nearness};
    }
  }
  return most;
}

std::string NearText(const language::Words& words, const Warned& warned) {
  if (warned.nearness <= 0) return {};
  const bool pulp = warned.about == sound::Hazard::kPulp;
  const double away_m = (1 - warned.nearness) * (pulp ? kWarnPulp_m : kWarnNeighbour_m);
  // Known to half a voxel, which is some hundredths of a millimetre.
  return words.Say(pulp ? "near.pulp" : "near.neighbour",
                   {{"distance", words.Decimal(1e3 * away_m, 1)}});
}

}  // namespace enamel::station::desk
