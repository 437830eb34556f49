#include "common/cutting/cutter.h"

#include <algorithm>
#include <cmath>

#include "common/cutting/brick_kernel.h"

namespace enamel::cutting {
namespace {

constexpr int kSide = kBrickSide;

struct Box {
  ivec3 lo, hi;  // bricks, inclusive
};

// Half extent of the bur's body about its middle, along each scene axis.
dvec3 HalfExtent(const Bur& bur, const dmat3& m) noexcept {
  if (bur.shape == BurShape::kSphere) return dvec3(bur.radius_m);
  dvec3 axis = m[2];
  dvec3 out;
  for (int i = 0; i < 3; ++i) {
    double s2 = 1 - axis[i] * axis[i];
    out[i] = 0.5 * bur.length_m * std::fabs(axis[i]) + bur.radius_m * std::sqrt(s2 > 0 ? s2 : 0);
  }
  return out;
}

int FloorToInt(double v) noexcept {
  int i = static_cast<int>(v);
  return v < i ? i - 1 : i;
}

Box BricksOf(const GridSpec& spec, const dvec3& lo_m, const dvec3& hi_m) noexcept {
  double h = spec.voxel_m();
  dvec3 origin = spec.origin_m();
  Box box;
  for (int i = 0; i < 3; ++i) {
    double top = spec.bricks[i] * kSide;
    double lo = std::clamp((lo_m[i] - origin[i]) / h, -1.0, top), hi = std::clamp((hi_m[i] - origin[i]) / h, -1.0, top);
    box.lo[i] = std::max(0, FloorToInt(lo) >> 3);
    box.hi[i] = std::min(spec.bricks[i] - 1, FloorToInt(hi) >> 3);
  }
  return box;
}

}  // namespace

Cutter::Cutter(Volume& volume, const Bur& bur)
    : volume_(volume), bur_(bur), voxel_m_(volume.spec().voxel_m()), kernel_(BestBrickKernel()) {
  const GridSpec& spec = volume.spec();
  min_phi_.resize(static_cast<size_t>(spec.brick_count()));
  for (int b = 0; b < spec.brick_count(); ++b) {
    min_phi_[static_cast<size_t>(b)] =
        volume.IsStored(b) ? *std::min_element(volume.Phi(b).phi.begin(), volume.Phi(b).phi.end())
        : volume.UniformTissue(b) == Tissue::kAir ? kPhiLimit
                                                  : static_cast<int16_t>(-kPhiLimit);
  }
  double reach = 2 * std::sqrt(bur.radius_m * bur.radius_m + 0.25 * bur.height_m() * bur.height_m()) +
                 2 * kSolidBandVoxels * voxel_m_;
  auto side = static_cast<size_t>(reach / (kSide * voxel_m_)) + 2;
  touched_.resize(std::min(side * side * side, min_phi_.size()));
}

void Cutter::VisitState(StateArchive& archive) {
  archive(min_phi_);
  touched_count_ = 0;
}

bool Cutter::AnySolidNear(const Pose& pose, double margin_m) const noexcept {
  dmat3 m = pose.orientation.Matrix();
  dvec3 middle = pose.tip_m + m[2] * (0.5 * bur_.height_m());
  dvec3 half = HalfExtent(bur_, m) + dvec3(margin_m);
  Box box = BricksOf(volume_.spec(), middle - half, middle + half);
  for (int z = box.lo.z; z <= box.hi.z; ++z)
    for (int y = box.lo.y; y <= box.hi.y; ++y)
      for (int x = box.lo.x; x <= box.hi.x; ++x)
        if (min_phi_[static_cast<size_t>(volume_.spec().BrickIndex(ivec3(x, y, z)))] < kPhiLimit) return true;
  return false;
}

bool Cutter::Cut(const Pose& pose, RemovedUnits& removed) noexcept {
  touched_count_ = 0;
  bool complete = true;
  const GridSpec& spec = volume_.spec();
  dmat3 m = pose.orientation.Matrix();
  dvec3 middle = pose.tip_m + m[2] * (0.5 * bur_.height_m());
  dvec3 half = HalfExtent(bur_, m) + dvec3(kSolidBandVoxels * voxel_m_);
  Box box = BricksOf(spec, middle - half, middle + half);
  dvec3 origin = spec.origin_m();
  // Farthest sample of a brick from the brick's middle, plus the rounding of the kernel.
  double brick_radius = 6.07 * voxel_m_;
  for (int z = box.lo.z; z <= box.hi.z; ++z) {
    for (int y = box.lo.y; y <= box.hi.y; ++y) {
      for (int x = box.lo.x; x <= box.hi.x; ++x) {
        int brick = spec.BrickIndex(ivec3(x, y, z));
        int lowest = min_phi_[static_cast<size_t>(brick)];
        if (lowest == kPhiLimit) continue;
        ivec3 first(x * kSide, y * kSide, z * kSide);
        dvec3 d = origin + (dvec3(first) + 3.5) * voxel_m_ - pose.tip_m;
        double nearest = bur_.Distance(dvec3(Dot(m[0], d), Dot(m[1], d), Dot(m[2], d))) - brick_radius;
        // The deepest any sample can be inside the bur; nothing changes unless that beats `lowest`.
        if (nearest > kSolidBandVoxels * voxel_m_ || -nearest * (kPhiPerVoxel / voxel_m_) <= lowest) continue;
        if (!volume_.Materialise(brick)) {
          complete = false;
          continue;
        }
        if (CutBrick(brick, first, m, pose.tip_m, removed)) touched_[touched_count_++] = brick;
      }
    }
  }
  return complete;
}

bool Cutter::CutBrick(int brick, const ivec3& first, const dmat3& m, const dvec3& tip_m,
                      RemovedUnits& removed) noexcept {
  const double inv_h = 1 / voxel_m_;
  const double half = 0.5 * bur_.height_m() * inv_h;
  dvec3 d = (volume_.spec().origin_m() - tip_m) * inv_h + dvec3(first);
  BrickFrame frame;
  for (int axis = 0; axis < 3; ++axis) {
    // Component along the bur's own axis; heights count from the bur's middle.
    frame.first[axis] = static_cast<float>(Dot(m[axis], d) - (axis == 2 ? half : 0));
    frame.dx[axis] = static_cast<float>(m[axis].x);
    frame.dy[axis] = static_cast<float>(m[axis].y);
    frame.dz[axis] = static_cast<float>(m[axis].z);
  }
  frame.radius = static_cast<float>(bur_.radius_m * inv_h);
  frame.half_length = static_cast<float>(half);
  int16_t* phi = volume_.MutablePhi(brick).phi.data();
  bool mixed = volume_.HasLabels(brick);
  std::array<int32_t, kBrickVoxels> gone;
  frame.lowest = min_phi_[static_cast<size_t>(brick)];
  frame.sphere = bur_.shape == BurShape::kSphere;
  BrickChange change = kernel_(frame, phi, mixed ? gone.data() : nullptr);
  min_phi_[static_cast<size_t>(brick)] = static_cast<int16_t>(change.lowest);
  if (change.removed != 0 && mixed) {
    const auto& labels = volume_.Labels(brick).tissue;
    for (size_t i = 0; i < kBrickVoxels; ++i) removed[labels[i]] += gone[i];
  } else {
    removed[static_cast<size_t>(volume_.UniformTissue(brick))] += change.removed;
  }
  return change.changed;
}

}  // namespace enamel::cutting
