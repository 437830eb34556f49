#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/cutting/profile.h"
#include "common/math/orientation.h"
#include "station/lab/bench/peers.h"

// Built where OpenVDB is installed.
namespace enamel::station::lab::bench {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;

constexpr float kBand = 3;  // voxels to either side of the surface: OpenVDB's usual half width

// Distances are in voxels, so that the grid's transform is the identity.
FloatGrid::Ptr GridOf(const cutting::Volume& volume) {
  auto grid = FloatGrid::create(kBand);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto at = grid->getAccessor();
  const cutting::GridSpec& spec = volume.spec();
  constexpr int kSide = cutting::kBrickSide;
  for (int z = 0; z < spec.bricks.z; ++z) {
    for (int y = 0; y < spec.bricks.y; ++y) {
      for (int x = 0; x < spec.bricks.x; ++x) {
        const int brick = spec.BrickIndex({x, y, z});
        const Coord from(x * kSide, y * kSide, z * kSide);
        if (!volume.IsStored(brick)) {
          // A brick of one tissue is a constant tile: inactive, below 0 inside.
          if (volume.UniformTissue(brick) != cutting::Tissue::kAir)
            grid->fill({from, from.offsetBy(kSide - 1)}, -kBand, false);
          continue;
        }
        for (int i = 0; i < cutting::kBrickVoxels; ++i) {
          // The block's own samples, so that both begin with the same surface.
          const float phi = static_cast<float>(volume.Phi(brick).phi[static_cast<size_t>(i)]) /
                            cutting::kPhiPerVoxel;
          const Coord c = from.offsetBy(i % kSide, i / kSide % kSide, i / (kSide * kSide));
          // OpenVDB's convention: the band is active, beyond it only the sign counts.
          if (std::fabs(phi) < kBand)
            at.setValueOn(c, phi);
          else
            at.setValueOff(c, phi < 0 ? -kBand : kBand);
        }
      }
    }
  }
  return grid;
}

// The bur's box in voxels, with the band around it, and its distance there.
class PlacedBur {
 public:
  PlacedBur(const cutting::Bur& bur, const cutting::Profile& profile, const cutting::GridSpec& spec,
            const cutting::Pose& pose)
      : profile_(profile),
        voxel_m_(spec.voxel_m()),
        from_bur_(pose.orientation.Matrix()),
        tip_((pose.tip_m - spec.origin_m()) / spec.voxel_m()) {
    const dvec3 end = tip_ + from_bur_[2] * (bur.height_m() / voxel_m_);
    for (int k = 0; k < 3; ++k) {
      const double reach =
          bur.radius_m / voxel_m_ * std::sqrt(std::max(0.0, 1 - from_bur_[2][k] * from_bur_[2][k]));
      low_[k] = static_cast<int>(std::floor(std::min(tip_[k], end[k]) - reach - kBand));
      high_[k] = static_cast<int>(std::ceil(std::max(tip_[k], end[k]) + reach + kBand));
    }
    // A sphere extends by its radius in every direction, also along the axis.
    if (bur.shape != cutting::BurShape::kSphere) return;
    const double r = bur.radius_m / voxel_m_;
    for (int k = 0; k < 3; ++k) {
      low_[k] = static_cast<int>(std::floor(std::min(tip_[k], end[k]) - r - kBand));
      high_[k] = static_cast<int>(std::ceil(std::max(tip_[k], end[k]) + r + kBand));
    }
  }

  const Coord& low() const { return low_; }
  const Coord& high() const { return high_; }
  float Distance(const Coord& c) const {
    const dvec3 p = dvec3(c.x(), c.y(), c.z()) - tip_;
    const double x = Dot(from_bur_[0], p), y = Dot(from_bur_[1], p), z = Dot(from_bur_[2], p);
    return static_cast<float>(profile_.Distance(std::sqrt(x * x + y * y) * voxel_m_, z * voxel_m_) /
                              voxel_m_);
  }

 private:
  const cutting::Profile& profile_;
  const double voxel_m_;
  const dmat3 from_bur_;
  const dvec3 tip_;
  Coord low_, high_;
};

// phi := max(phi, -bur), block by block of the grid's leaves; skips air.
void CarveInPlace(FloatGrid::Accessor& at, const PlacedBur& bur) {
  constexpr int kLeaf = 8;
  const Coord low = bur.low() & ~(kLeaf - 1);
  for (int x = low.x(); x <= bur.high().x(); x += kLeaf) {
    for (int y = low.y(); y <= bur.high().y(); y += kLeaf) {
      for (int z = low.z(); z <= bur.high().z(); z += kLeaf) {
        const Coord from(x, y, z);
        // Air stays air under max: a missing leaf stays missing.
        if (at.probeConstLeaf(from) == nullptr && at.getValue(from) > 0) continue;
        const Coord first = Coord::maxComponent(from, bur.low()),
                    last = Coord::minComponent(from.offsetBy(kLeaf - 1), bur.high());
        Coord c;
        for (c.x() = first.x(); c.x() <= last.x(); ++c.x()) {
          for (c.y() = first.y(); c.y() <= last.y(); ++c.y()) {
            for (c.z() = first.z(); c.z() <= last.z(); ++c.z()) {
              const float outside = -bur.Distance(c);
              if (outside <= -kBand || outside <= at.getValue(c)) continue;
              if (outside < kBand)
                at.setValueOn(c, outside);
              else
                at.setValueOff(c, kBand);
            }
          }
        }
      }
    }
  }
}

void CarveByCsg(FloatGrid& tooth, const PlacedBur& bur) {
  auto grid = FloatGrid::create(kBand);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto at = grid->getAccessor();
  Coord c;
  for (c.x() = bur.low().x(); c.x() <= bur.high().x(); ++c.x()) {
    for (c.y() = bur.low().y(); c.y() <= bur.high().y(); ++c.y()) {
      for (c.z() = bur.low().z(); c.z() <= bur.high().z(); ++c.z()) {
        const float d = bur.Distance(c);
        if (std::fabs(d) < kBand) at.setValueOn(c, d);
      }
    }
  }
  // csgDifference needs signs inside too, which the band alone lacks.
  openvdb::tools::signedFloodFill(grid->tree());
  openvdb::tools::csgDifference(tooth, *grid);
}

// Volume in voxels; one crossed by the surface counts by its distance.
double SolidVoxels(const FloatGrid& grid, const cutting::GridSpec& spec) {
  auto at = grid.getConstAccessor();
  double sum = 0;
  const ivec3 n = spec.voxels();
  for (int x = 0; x < n.x; ++x) {
    for (int y = 0; y < n.y; ++y) {
      for (int z = 0; z < n.z; ++z)
        // A plane through a voxel at distance d leaves 1/2 - d of the voxel, if it is nearly
        // parallel to a face.
        sum += std::clamp(0.5 - static_cast<double>(at.getValue(Coord(x, y, z))), 0.0, 1.0);
    }
  }
  return sum;
}

}  // namespace

bool HasOpenVdb() { return true; }

std::vector<PeerCost> TimeOpenVdb(const CutPath& path, const std::vector<cutting::Pose>& poses,
                                  int replays) {
  openvdb::initialize();
  // One thread, like a tick.
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const cutting::GridSpec& spec = path.block.spec();
  const cutting::Profile profile = cutting::ProfileOf(path.bur);
  std::vector<PeerCost> out;
  for (bool csg : {false, true}) {
    PeerCost cost{.what = csg ? "OpenVDB, csgDifference" : "OpenVDB, accessor"};
    std::vector<double> least(poses.size() - path.first_measured, 1e12);
    for (int r = 0; r < replays; ++r) {
      FloatGrid::Ptr tooth = GridOf(path.block);
      const double before = r == 0 ? SolidVoxels(*tooth, spec) : 0;
      auto at = tooth->getAccessor();
      for (size_t i = 0; i < poses.size(); ++i) {
        // The lead-in is cut in the cheaper way: csgDifference gives the same values.
        const bool measured = i >= path.first_measured;
        auto from = std::chrono::steady_clock::now();
        const PlacedBur bur(path.bur, profile, spec, poses[i]);
        if (csg && measured)
          CarveByCsg(*tooth, bur);
        else
          CarveInPlace(at, bur);
        std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - from;
        if (!measured) continue;
        double& best = least[i - path.first_measured];
        best = std::min(best, took.count());
      }
      if (r == 0)
        cost.removed_mm3 = (before - SolidVoxels(*tooth, spec)) * std::pow(spec.voxel_m() * 1e3, 3);
    }
    Spread spread = SpreadOf(std::move(least));
    cost.mean_us = spread.mean, cost.p99_us = spread.p99;
    out.push_back(std::move(cost));
  }
  return out;
}

}  // namespace enamel::station::lab::bench
