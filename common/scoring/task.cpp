#include "common/scoring/task.h"

#include <algorithm>
#include <cmath>

#include "common/scoring/brick_samples.h"
#include "common/scoring/deviation.h"

namespace enamel::scoring {
namespace {

using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::Volume;

// Where a brick lies relative to the reference's cut: within some distance of it, or not.
enum class Place { kUnknown, kNear, kOutside, kMixed };

class TaskMeter {
 public:
  TaskMeter(const Volume& initial, const Volume& attempt, const Volume& reference,
            const surface::DistanceQuery& reference_cut, double near_m)
      : initial_(initial),
        attempt_(attempt),
        reference_(reference),
        query_(reference_cut),
        spec_(initial.spec()),
        h_m_(spec_.voxel_m()),
        near_m_(near_m),
        attempt_changed_(initial, attempt),
        reference_changed_(initial, reference) {}

  TaskVolumes Measure() {
    for (int b = 0; b < spec_.brick_count(); ++b) AddBrick(b);
    return {ToM3(task_), ToM3(missed_), ToM3(standing_), ToM3(near_), ToM3(outside_)};
  }

 private:
  using Units = std::array<int64_t, cutting::kTissueCount>;  // 65536 to a voxel

  void AddBrick(int b) {
    if (!attempt_changed_.Brick(b) && !reference_changed_.Brick(b)) return;
    const BrickSamples before(initial_, b), after(attempt_, b), wanted(reference_, b);
    const uint8_t* labels = initial_.HasLabels(b) ? initial_.Labels(b).tissue.data() : nullptr;
    const auto uniform = static_cast<size_t>(initial_.UniformTissue(b));
    Whereabouts beyond(*this, b, near_m_), standing(*this, b, TaskVolumes::kStanding_m);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const int32_t f0 = before.Solid(i);
      if (f0 == 0) continue;
      // A surface may only recede: what a resampled reference has more of was not put there.
      const int32_t fa = std::min(f0, after.Solid(i)), fr = std::min(f0, wanted.Solid(i));
      if (fa == f0 && fr == f0) continue;
      const size_t tissue = labels ? labels[i] : uniform;
      task_[tissue] += f0 - fr;
      if (fa > fr) {
        missed_[tissue] += fa - fr;
        if (!standing.IsNear(i)) standing_[tissue] += fa - fr;
      } else if (fa < fr) {
        (beyond.IsNear(i) ? near_ : outside_)[tissue] += fr - fa;
      }
    }
  }

  // Which voxels of a brick are within a distance of the reference's cut; computed on demand.
  class Whereabouts {
   public:
    Whereabouts(const TaskMeter& meter, int brick, double within_m)
        : meter_(meter), brick_(brick), within_m_(within_m) {}
    bool IsNear(int i) {
      if (place_ == Place::kUnknown) place_ = meter_.PlaceOf(brick_, within_m_);
      if (place_ != Place::kMixed) return place_ == Place::kNear;
      return meter_.query_.IsWithin(meter_.VoxelPoint(brick_, i), within_m_);
    }

   private:
    const TaskMeter& meter_;
    const int brick_;
    const double within_m_;
    Place place_ = Place::kUnknown;
  };

  ivec3 FirstVoxel(int b) const {
    const ivec3& n = spec_.bricks;
    return ivec3(b % n.x, b / n.x % n.y, b / (n.x * n.y)) * kBrickSide;
  }
  dvec3 VoxelPoint(int b, int i) const {
    return spec_.origin_m() + dvec3(FirstVoxel(b) + ivec3(i & 7, i >> 3 & 7, i >> 6)) * h_m_;
  }
  // One question for a brick that lies wholly on one side, which most do.
  Place PlaceOf(int b, double within_m) const {
    dvec3 middle = spec_.origin_m() + (dvec3(FirstVoxel(b)) + 0.5 * (kBrickSide - 1)) * h_m_;
    const double half = 0.5 * (kBrickSide - 1) * std::sqrt(3.0) * h_m_;
    const double limit = within_m + half + h_m_;
    const double distance = query_.Distance_m(middle, limit);
    if (distance > within_m + half) return Place::kOutside;
    return distance + half <= within_m ? Place::kNear : Place::kMixed;
  }

  TissueVolumes_m3 ToM3(const Units& units) const {
    TissueVolumes_m3 out{};
    for (size_t t = 0; t < units.size(); ++t) {
      out[t] = static_cast<double>(units[t]) * (h_m_ * h_m_ * h_m_ / 65536);
    }
    return out;
  }

  const Volume &initial_, &attempt_, &reference_;
  const surface::DistanceQuery& query_;
  const cutting::GridSpec& spec_;
  const double h_m_, near_m_;
  const ChangedBricks attempt_changed_, reference_changed_;
  Units task_{}, missed_{}, standing_{}, near_{}, outside_{};
};

}  // namespace

double Sum_m3(const TissueVolumes_m3& volumes) {
  double sum = 0;
  for (double v : volumes) sum += v;
  return sum;
}

std::vector<bool> CutVertices(const surface::Mesh& mesh, const Volume& initial,
                              const Volume& after) {
  std::vector<bool> out(mesh.position_m.size());
  const CutTest cut(initial, after);
  for (size_t i = 0; i < out.size(); ++i) out[i] = cut.At(dvec3(mesh.position_m[i]));
  return out;
}

surface::Mesh CutPart(const surface::Mesh& mesh, const std::vector<bool>& cut) {
  surface::Mesh out = mesh;
  std::erase_if(out.triangles,
                [&](const auto& t) { return !cut[t[0]] && !cut[t[1]] && !cut[t[2]]; });
  return out;
}

TaskVolumes MeasureTask(const Volume& initial, const Volume& attempt, const Volume& reference,
                        const surface::DistanceQuery& reference_cut, double near_m) {
  return TaskMeter(initial, attempt, reference, reference_cut, near_m).Measure();
}

}  // namespace enamel::scoring
