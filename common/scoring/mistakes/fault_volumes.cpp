#include "common/scoring/mistakes/fault_volumes.h"

#include <algorithm>
#include <array>

#include "common/math/ramp.h"
#include "common/scoring/brick_samples.h"
#include "common/scoring/changed.h"

namespace enamel::scoring {
namespace {

using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::Tissue;

double ElsewhereShare(double distance_m) {
  return Ramp(distance_m, kElsewhereFrom_m, kElsewhereTo_m);
}
// How far a cut at a distance from R's surface continues one at the surface, 0 to 1, by the share that was taken of the
// layer next to the surface. A hole beside a wall leaves that layer; a wall that is too far out has none of it. Chosen.
constexpr double kNext_m = 0.2e-3;
double Attached(double next_m3, double area_m2) {
  return area_m2 > 0 ? Ramp(next_m3 / (area_m2 * kNext_m), 0.1, 0.4) : 0;
}

// The volume nearest to a small piece at a rim is many times what its area holds, so a piece is off by no more than this
// times the farthest distance that was found there. A piece in the middle of a surface may hold half as many voxels again
// as its area. Chosen.
constexpr double kMost = 1.5;

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
    out_.elsewhere.resize(n), out_.off_m.resize(n), at_.resize(n), next_m3_.resize(n);
    if (r.contact()) out_.contact_left_m.resize(r.contact()->row_count());
  }

  FaultVolumes Measure() {
    for (int b = 0; b < spec_.brick_count(); ++b) {
      if (task_.Brick(b) || cut_.Brick(b)) AddBrick(b);
    }
    out_.pulp_m3 *= r_.pulp_counts();
    if (out_.far_m3 > 0) out_.far_at_m = far_sum_ / out_.far_m3;
    for (size_t k = 0; k < at_.size(); ++k) {
      const double area = r_.pieces()[k].area_m2;
      out_.elsewhere[k].attached = Attached(next_m3_[k], area);
      if (!(area > 0)) continue;
      const Nearby& at = at_[k];
      const double over_m3 = at.over_m3 + at.away_m3 * Attached(at.next_m3, area);
      out_.off_m[k] = std::clamp((over_m3 - at.left_m3) / area, -kMost * at.farthest_left_m,
                                 kMost * at.farthest_over_m);
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
      int32_t fa = std::min(f0, after.Solid(i));
      const int32_t fr = std::min(f0, wanted.Solid(i));
      const auto tissue = static_cast<Tissue>(labels ? labels[i] : uniform);
      if (tissue == Tissue::kCaries) out_.caries_m3 += Share(f0 - fr) * voxel_m3_;
      if (fa == fr) continue;
      if (tissue == Tissue::kNeighbour) {
        if (fa < fr) AddNeighbour(b, i, Share(fr - fa));
        continue;
      }
      if (fr == 0) fa = std::min(fa, ThinSolid(b, i, fa));
      if (fa < fr && IsFlakeOfR(b, i)) continue;
      Add(places, {b, i, tissue}, Share(f0), Share(fa), Share(fr));
    }
  }

  static constexpr int32_t kWhole = 65536;
  static double Share(int32_t units) { return units / double{kWhole}; }

  struct Voxel {
    int brick = 0, number = 0;
    Tissue tissue{};
  };
  // The share of a voxel that is deeper than the leeway under the untouched surface: nobody sees where less was polished
  // off. The distance is known down to four voxels.
  double Seen(const Voxel& v) const {
    const int phi = r_.initial().PhiAt(VoxelOf(v.brick, v.number));
    if (phi <= -cutting::kPhiLimit) return 1;
    const double depth_m = -h_m_ * phi / cutting::kPhiPerVoxel;
    return std::clamp((depth_m - kLeeway_m) / h_m_ + 0.5, 0.0, 1.0);
  }

  // The share of what was taken from a voxel that belongs to no film off the untouched surface. A film is thinner than the
  // leeway between that surface and the attempt's. A larger cut only moves the attempt's surface away.
  double Deep(const Voxel& v) const {
    const ivec3 at = VoxelOf(v.brick, v.number);
    const double from = r_.initial().PhiAt(at), to = attempt_.PhiAt(at);
    if (from <= -cutting::kPhiLimit || to >= cutting::kPhiLimit) return 1;
    const double taken_m = h_m_ * (to - from) / cutting::kPhiPerVoxel;
    return std::clamp((taken_m - kLeeway_m) / h_m_ + 0.5, 0.0, 1.0);
  }

  void Add(AcceptableCut::Brick& places, const Voxel& voxel, double f0, double fa, double fr) {
    const int i = voxel.number;
    const Tissue tissue = voxel.tissue;
    const double over = fr > fa ? (fr - fa) * Deep(voxel) : 0, left = fa - fr;
    if (tissue == Tissue::kPulp) out_.pulp_m3 += std::max(0.0, over) * voxel_m3_;
    const auto nearest = places.At(i);
    if (!nearest) {
      const double far = over > 0 ? over * voxel_m3_ * Seen(voxel) : 0;
      out_.far_m3 += far;
      far_sum_ += far * places.PointOf(i);
      return;
    }
    const size_t k = nearest->piece();
    const double farthest_m = nearest->distance_m + 0.5 * h_m_;
    const double solid_side_m = fr > 0.5 * f0 ? nearest->distance_m : -nearest->distance_m;
    if (over > 0) {
      const Layer layer = Layer::In(solid_side_m, h_m_, over);
      // By the voxel's middle, which R alone fixes: more taken from it adds to both.
      const double away = ElsewhereShare(solid_side_m) * over * voxel_m3_;
      const double seen = away > 0 ? away * Seen(voxel) : 0;
      out_.elsewhere[k].volume_m3 += seen;
      out_.elsewhere[k].moment_m4 += seen * places.PointOf(i);
      for (const auto& [piece, share] : nearest->Payers()) {
        AddTo(out_.over[piece], share * (over * voxel_m3_ - away), layer);
      }
      const double next = over * voxel_m3_ * NextShare(solid_side_m);
      next_m3_[k] += next;
      for (const auto& [piece, share] : nearest->Nearby()) {
        if (!(share > 0)) continue;
        Nearby& at = at_[piece];
        at.over_m3 += share * (over * voxel_m3_ - away), at.away_m3 += share * away;
        at.next_m3 += share * next;
        at.farthest_over_m = std::max(at.farthest_over_m, farthest_m);
      }
    }
    if (left > 0) {
      const Layer layer = Layer::In(-solid_side_m, h_m_, left);
      const double beyond_m3 = left * voxel_m3_ * layer.Beyond();
      out_.left_beyond_m3 += beyond_m3;
      const auto row = r_.contact() ? r_.contact()->RowAt(voxel.brick, i) : std::nullopt;
      if (tissue == Tissue::kCaries) {
        out_.caries_left_m3 += beyond_m3;
      } else if (row) {
        out_.contact_left_m[*row] += left * h_m_;
      } else {
        for (const auto& [piece, share] : nearest->Payers()) {
          AddTo(out_.left[piece], share * left * voxel_m3_, layer);
        }
      }
      for (const auto& [piece, share] : nearest->Nearby()) {
        if (!(share > 0)) continue;
        at_[piece].left_m3 += share * left * voxel_m3_;
        at_[piece].farthest_left_m = std::max(at_[piece].farthest_left_m, farthest_m);
      }
    }
  }

  // A film between two surfaces that no other voxel of its row meets. Its middle is half of the difference of the distances
  // on either side off the voxel's, and its half thickness is the rest of the distance there. SolidFraction knows one
  // surface only, and calls a film of no thickness up to half a voxel.
  int32_t ThinSolid(int b, int i, int32_t solid) const {
    if (solid == 0) return 0;
    const ivec3 voxel = VoxelOf(b, i), all = spec_.voxels();
    for (int axis = 0; axis < 3; ++axis) {
      ivec3 before = voxel, after = voxel;
      --before[axis], ++after[axis];
      if (before[axis] < 0 || after[axis] >= all[axis]) continue;
      const int to_before = attempt_.PhiAt(before), to_after = attempt_.PhiAt(after);
      if (cutting::SolidFraction(to_before) > 0 || cutting::SolidFraction(to_after) > 0) continue;
      const int thick = std::abs(to_before - to_after) - 2 * attempt_.PhiAt(voxel);
      solid = std::min(solid, std::max(0, thick) * (kWhole / cutting::kPhiPerVoxel));
    }
    return solid;
  }

  // R leaves less than a voxel between its hollow and the air, or the neighbour: at a contact the labels of a grid decide
  // whether it does. Nobody misses it.
  bool IsFlakeOfR(int b, int i) const {
    const cutting::Volume& prepared = r_.prepared();
    const ivec3 voxel = VoxelOf(b, i), all = spec_.voxels();
    auto tooth = [&](const ivec3& at) {
      const int phi = prepared.PhiAt(at);
      return r_.initial().TissueAt(at) == Tissue::kNeighbour ? 0 : cutting::SolidFraction(phi);
    };
    auto taken = [&](const ivec3& at) { return prepared.PhiAt(at) > r_.initial().PhiAt(at); };
    const int32_t own = tooth(voxel);
    for (int axis = 0; axis < 3; ++axis) {
      ivec3 before = voxel, after = voxel;
      --before[axis], ++after[axis];
      if (before[axis] < 0 || after[axis] >= all[axis]) continue;
      const int32_t a = tooth(before), c = tooth(after);
      if (2 * std::max(a, c) < kWhole && a + own + c <= kWhole && (taken(before) || taken(after)))
        return true;
    }
    return false;
  }

  // The share of a voxel that is in the layer next to R's surface.
  double NextShare(double distance_m) const {
    return std::clamp((kNext_m - distance_m) / h_m_ + 0.5, 0.0, 1.0);
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
    double over_m3 = 0, away_m3 = 0, next_m3 = 0, left_m3 = 0;
    double farthest_over_m = 0, farthest_left_m = 0;
  };
  std::vector<Nearby> at_;       // where a piece is the nearest
  std::vector<double> next_m3_;  // where a piece pays: taken from the layer next to it
  FaultVolumes out_;
};

}  // namespace

FaultVolumes MeasureFaults(const AcceptableCut& r, const cutting::Volume& attempt) {
  return FaultMeter(r, attempt).Measure();
}

}  // namespace enamel::scoring
