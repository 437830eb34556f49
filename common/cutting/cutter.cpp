#include "common/cutting/cutter.h"

#include <algorithm>
#include <cmath>

namespace enamel::cutting {
namespace {

// Samples farther than this outside the bur are left as they are: two voxels beside the new
// surface are enough for its gradient, its mesh and the engagement reading.
constexpr double kCutBandVoxels = 2;
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

// Distance of the bur at eight points of a row, in voxels. Single precision is enough (1e-5 voxel)
// and element-wise IEEE operations vectorise without changing a bit.
struct RowKernel {
  float radius, half_length, centre_z;
  bool sphere;

  void Row(float x, float y, float z, const float* dx, const float* dy, const float* dz,
           float* out) const noexcept {
    if (sphere) {
      for (int i = 0; i < kSide; ++i) {
        float px = x + dx[i], py = y + dy[i], pz = (z + dz[i]) - centre_z;
        out[i] = std::sqrt((px * px + py * py) + pz * pz) - radius;
      }
    } else {
      for (int i = 0; i < kSide; ++i) {
        float px = x + dx[i], py = y + dy[i], pz = (z + dz[i]) - centre_z;
        float side = std::sqrt(px * px + py * py) - radius;
        float end = std::fabs(pz) - half_length;
        float inside = side > end ? side : end;
        float s = side > 0 ? side : 0, e = end > 0 ? end : 0;
        float outside = std::sqrt(s * s + e * e);
        out[i] = inside > 0 ? outside : inside;
      }
    }
  }
};

}  // namespace

Cutter::Cutter(Volume& volume, const Bur& bur)
    : volume_(volume), bur_(bur), voxel_m_(volume.spec().voxel_m()) {
  const GridSpec& spec = volume.spec();
  min_phi_.resize(static_cast<size_t>(spec.brick_count()));
  for (int b = 0; b < spec.brick_count(); ++b) {
    min_phi_[static_cast<size_t>(b)] =
        volume.IsStored(b) ? *std::min_element(volume.Phi(b).phi.begin(), volume.Phi(b).phi.end())
        : volume.UniformTissue(b) == Tissue::kAir ? kPhiLimit
                                                  : static_cast<int16_t>(-kPhiLimit);
  }
  double reach = 2 * std::sqrt(bur.radius_m * bur.radius_m + 0.25 * bur.height_m() * bur.height_m()) +
                 2 * kCutBandVoxels * voxel_m_;
  auto side = static_cast<size_t>(reach / (kSide * voxel_m_)) + 2;
  touched_.resize(std::min(side * side * side, min_phi_.size()));
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
  dvec3 half = HalfExtent(bur_, m) + dvec3(kCutBandVoxels * voxel_m_);
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
        if (nearest > kCutBandVoxels * voxel_m_ || -nearest * (kPhiPerVoxel / voxel_m_) <= lowest) continue;
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
  RowKernel kernel{static_cast<float>(bur_.radius_m * inv_h),
                   static_cast<float>(0.5 * bur_.height_m() * inv_h),
                   static_cast<float>(0.5 * bur_.height_m() * inv_h), bur_.shape == BurShape::kSphere};
  // First sample in the bur frame, in voxels; the step along scene x, y, z is a row of the matrix.
  dvec3 d = (volume_.spec().origin_m() - tip_m) * inv_h + dvec3(first);
  float q0 = static_cast<float>(Dot(m[0], d)), q1 = static_cast<float>(Dot(m[1], d)), q2 = static_cast<float>(Dot(m[2], d));
  float ax[3], ay[3], az[3];
  for (int i = 0; i < 3; ++i) {
    ax[i] = static_cast<float>(m[i].x);
    ay[i] = static_cast<float>(m[i].y);
    az[i] = static_cast<float>(m[i].z);
  }
  float dx[kSide], dy[kSide], dz[kSide];
  for (int i = 0; i < kSide; ++i) {
    dx[i] = static_cast<float>(i) * ax[0];
    dy[i] = static_cast<float>(i) * ax[1];
    dz[i] = static_cast<float>(i) * ax[2];
  }
  constexpr float kScale = kPhiPerVoxel;
  constexpr float kLimit = kPhiLimit;
  constexpr float kBandLimit = -static_cast<float>(kCutBandVoxels) * kPhiPerVoxel;
  int16_t* phi = volume_.MutablePhi(brick).phi.data();
  const uint8_t* labels = volume_.HasLabels(brick) ? volume_.Labels(brick).tissue.data() : nullptr;
  auto uniform = static_cast<size_t>(volume_.UniformTissue(brick));
  int lowest = kPhiLimit;
  int64_t total = 0;
  bool changed = false;
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      auto fy = static_cast<float>(y), fz = static_cast<float>(z);
      float dist[kSide];
      kernel.Row(q0 + (fy * ay[0] + fz * az[0]), q1 + (fy * ay[1] + fz * az[1]),
                 q2 + (fy * ay[2] + fz * az[2]), dx, dy, dz, dist);
      int gone[kSide];
      int16_t* row = phi + (z * kSide + y) * kSide;
      int row_changed = 0, row_lowest = kPhiLimit, row_total = 0;
      for (int i = 0; i < kSide; ++i) {
        float v = -dist[i] * kScale;
        v = v < kLimit ? v : kLimit;
        v = v > kBandLimit ? v : -kLimit;
        int fresh = static_cast<int>(v), old = row[i];
        int now = fresh > old ? fresh : old;
        int before = 32768 - old * 8, after = 32768 - now * 8;
        before = before < 0 ? 0 : before > 65536 ? 65536 : before;
        after = after < 0 ? 0 : after > 65536 ? 65536 : after;
        gone[i] = before - after;
        row_total += gone[i];
        row_changed |= now ^ old;
        row_lowest = now < row_lowest ? now : row_lowest;
        row[i] = static_cast<int16_t>(now);
      }
      changed |= row_changed != 0;
      lowest = row_lowest < lowest ? row_lowest : lowest;
      total += row_total;
      if (labels && row_total != 0) {
        for (int i = 0; i < kSide; ++i) removed[labels[(z * kSide + y) * kSide + i]] += gone[i];
      }
    }
  }
  if (!labels) removed[uniform] += total;
  min_phi_[static_cast<size_t>(brick)] = static_cast<int16_t>(lowest);
  return changed;
}

}  // namespace enamel::cutting
