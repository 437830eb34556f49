#include "common/scoring/mistakes/fault_volumes.h"

#include <algorithm>
#include <array>

#include "common/scoring/brick_samples.h"
#include "common/scoring/changed.h"

namespace enamel::scoring {
namespace {

using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::Tissue;

// 0 to 1, without a corner at either end.
double SmoothStep(double value, double from, double to) {
  const double t = std::clamp((value - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
double ElsewhereShare(double distance_m) {
  return SmoothStep(distance_m, kElsewhereFrom_m, kElsewhereTo_m);
}
// A hole beside a wall leaves most of the layer at the wall standing; a wall that is far out does not. Chosen.
double Attached(double taken_m3, double area_m2) {
  constexpr double kFrom_m = 0.5 * kElsewhereFrom_m, kTo_m = kElsewhereFrom_m;
  return area_m2 > 0 ? SmoothStep(taken_m3 / area_m2, kFrom_m, kTo_m) : 0;
}

class FaultMeter {
 public:
  FaultMeter(const AcceptableCut& r, const cutting::Volume& attempt)
      : r_(r),
        attempt_(attempt),
        spec_(r.initial().spec()),
        h_m_(spec_.voxel_m()),
        voxel_m3_(h_m_ * h_m_ * h_m_),
        task_(r.initial(), r.prepared()),
        cut_(r.initial(), attempt) {
    const size_t n = r.pieces().size();
    out_.over.resize(n), out_.left.resize(n);
    out_.elsewhere.resize(n), out_.off_m.resize(n), at_.resize(n);
  }

  FaultVolumes Measure() {
    for (int b = 0; b < spec_.brick_count(); ++b) {
      if (task_.Brick(b) || cut_.Brick(b)) AddBrick(b);
    }
    if (out_.far_m3 > 0) out_.far_at_m = far_sum_ / out_.far_m3;
    for (size_t k = 0; k < at_.size(); ++k) {
      const double area = r_.pieces()[k].area_m2;
      out_.elsewhere[k].attached = Attached(out_.over[k].volume_m3, area);
      if (!(area > 0)) continue;
      const Nearby& at = at_[k];
      const double over_m3 = at.over_m3 + at.away_m3 * Attached(at.over_m3, area);
      out_.off_m[k] =
          std::clamp((over_m3 - at.left_m3) / area, -at.farthest_left_m, at.farthest_over_m);
    }
    return std::move(out_);
  }

 private:
  void AddBrick(int b) {
    const BrickSamples before(r_.initial(), b), after(attempt_, b), wanted(r_.prepared(), b);
    const cutting::Volume& initial = r_.initial();
    const uint8_t* labels = initial.HasLabels(b) ? initial.Labels(b).tissue.data() : nullptr;
    const auto uniform = static_cast<uint8_t>(initial.UniformTissue(b));
    AcceptableCut::Brick places(r_, b, kDeepest_m);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const int32_t f0 = before.Solid(i);
      if (f0 == 0) continue;
      // A surface may only recede: what a resampled R has more of was not put there.
      const int32_t fa = std::min(f0, after.Solid(i)), fr = std::min(f0, wanted.Solid(i));
      const auto tissue = static_cast<Tissue>(labels ? labels[i] : uniform);
      if (tissue == Tissue::kCaries) out_.caries_m3 += Share(f0 - fr) * voxel_m3_;
      if (fa == fr) continue;
      if (tissue == Tissue::kNeighbour) {
        if (fa < fr) AddNeighbour(b, i, Share(fr - fa));
        continue;
      }
      if (fr == 0 && IsFilm(b, i, fa)) continue;
      Add(places, i, tissue, Share(f0), Share(fa), Share(fr));
    }
  }

  static constexpr int32_t kWhole = 65536;
  static double Share(int32_t units) { return units / double{kWhole}; }

  void Add(AcceptableCut::Brick& places, int i, Tissue tissue, double f0, double fa, double fr) {
    const double over = fr - fa, left = fa - fr;
    if (tissue == Tissue::kPulp && over > 0) out_.pulp_m3 += over * voxel_m3_;
    const auto nearest = places.At(i);
    if (!nearest) {
      out_.far_m3 += std::max(0.0, over) * voxel_m3_;
      far_sum_ += std::max(0.0, over) * voxel_m3_ * places.PointOf(i);
      return;
    }
    const size_t k = nearest->piece;
    Nearby& at = at_[nearest->next_to];
    const double farthest_m = nearest->distance_m + 0.5 * h_m_;
    const double solid_side_m = fr > 0.5 * f0 ? nearest->distance_m : -nearest->distance_m;
    if (over > 0) {
      const Layer layer = Layer::In(solid_side_m, h_m_, over);
      // By the voxel's middle, which R alone fixes: more taken from it adds to both.
      const double away = ElsewhereShare(solid_side_m) * over * voxel_m3_;
      out_.elsewhere[k].volume_m3 += away;
      out_.elsewhere[k].moment_m4 += away * places.PointOf(i);
      AddTo(out_.over[k], over * voxel_m3_ - away, layer);
      at.over_m3 += over * voxel_m3_ - away, at.away_m3 += away;
      at.farthest_over_m = std::max(at.farthest_over_m, farthest_m);
    }
    if (left > 0) {
      const Layer layer = Layer::In(-solid_side_m, h_m_, left);
      const double beyond_m3 = left * voxel_m3_ * layer.Beyond();
      out_.left_beyond_m3 += beyond_m3;
      if (tissue == Tissue::kCaries)
        out_.caries_left_m3 += beyond_m3;
      else
        AddTo(out_.left[k], left * voxel_m3_, layer);
      at.left_m3 += left * voxel_m3_;
      at.farthest_left_m = std::max(at.farthest_left_m, farthest_m);
    }
  }

  // Half a voxel that has nothing on either side: less than the grid can show.
  bool IsFilm(int b, int i, int32_t solid) const {
    if (solid == 0 || 2 * solid > kWhole) return false;
    const ivec3 voxel = VoxelOf(b, i), all = spec_.voxels();
    for (int axis = 0; axis < 3; ++axis) {
      ivec3 before = voxel, after = voxel;
      --before[axis], ++after[axis];
      if (before[axis] < 0 || after[axis] >= all[axis]) continue;
      if (cutting::SolidFraction(attempt_.PhiAt(before)) == 0 &&
          cutting::SolidFraction(attempt_.PhiAt(after)) == 0)
        return true;
    }
    return false;
  }

  static void AddTo(PieceFault& fault, double volume_m3, const Layer& layer) {
    fault.volume_m3 += volume_m3;
    fault.moment_m5 += volume_m3 * layer.Moment_m2();
  }

  void AddNeighbour(int b, int i, double over) {
    // The fixed point's own distance, which ends at four voxels.
    constexpr double kDeep_m = 0.4e-3;
    const double depth_m =
        std::min(kDeep_m, -h_m_ * r_.initial().PhiAt(VoxelOf(b, i)) / cutting::kPhiPerVoxel);
    out_.neighbour_moment_m5 += over * voxel_m3_ * std::max(0.0, depth_m) * std::max(0.0, depth_m);
  }
  ivec3 VoxelOf(int b, int i) const {
    const ivec3& n = spec_.bricks;
    return ivec3(b % n.x, b / n.x % n.y, b / (n.x * n.y)) * kBrickSide +
           ivec3(i & 7, i >> 3 & 7, i >> 6);
  }

  const AcceptableCut& r_;
  const cutting::Volume& attempt_;
  const cutting::GridSpec spec_;
  const double h_m_, voxel_m3_;
  const ChangedBricks task_, cut_;
  dvec3 far_sum_{0};
  struct Nearby {
    double over_m3 = 0, away_m3 = 0, left_m3 = 0;
    double farthest_over_m = 0, farthest_left_m = 0;
  };
  std::vector<Nearby> at_;  // where a piece is the nearest
  FaultVolumes out_;
};

}  // namespace

FaultVolumes MeasureFaults(const AcceptableCut& r, const cutting::Volume& attempt) {
  return FaultMeter(r, attempt).Measure();
}

}  // namespace enamel::scoring
