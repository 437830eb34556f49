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
// A disc of radius r across the axis a reaches r sqrt(1 - a_i^2) along axis i. Every shape but the
// ball is taken as the cylinder around it: a little too large costs some bricks that are then
// culled.
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
    // Clamped before the cast: counts can mean kilometres, more voxels than an int holds.
    double top = spec.bricks[i] * kSide;
    double lo = std::clamp((lo_m[i] - origin[i]) / h, -1.0, top),
           hi = std::clamp((hi_m[i] - origin[i]) / h, -1.0, top);
    box.lo[i] = std::max(0, FloorToInt(lo) >> 3);
    box.hi[i] = std::min(spec.bricks[i] - 1, FloorToInt(hi) >> 3);
  }
  return box;
}

// In voxels, by pieces of a double affine map: `first` at sample (0, 0, 0) of the grid.
// Summed in double and rounded once for each brick: single precision from the corner of a grid of
// 4096 bricks would be off by 1/500 voxel at its other end.
struct Affine {
  dvec3 first;
  dmat3 steps;  // columns: dx, dy, dz

  BurFrame At(const ivec3& sample) const noexcept {
    dvec3 at = first + steps * dvec3(sample);
    BurFrame f;
    for (int i = 0; i < 3; ++i) {
      f.first[i] = static_cast<float>(at[i]);
      f.dx[i] = static_cast<float>(steps[0][i]);
      f.dy[i] = static_cast<float>(steps[1][i]);
      f.dz[i] = static_cast<float>(steps[2][i]);
    }
    return f;
  }
};

}  // namespace

struct Cutter::Placed {
  Affine bur_from_sample;
  Box box;
};

Cutter::Cutter(Volume& volume, std::span<const Bur> burs)
    : volume_(volume), voxel_m_(volume.spec().voxel_m()), kernels_(BestKernels()) {
  ENAMEL_CHECK(!burs.empty());
  const GridSpec& spec = volume.spec();
  // Eight are read at a time.
  min_phi_.resize(static_cast<size_t>(spec.brick_count()) + 7, kPhiLimit);
  for (int b = 0; b < spec.brick_count(); ++b) min_phi_[static_cast<size_t>(b)] = volume.Lowest(b);
  // The most bricks that a cut's box meets, for any orientation: the box is no longer than the
  // diagonal of the body plus the band, and a length of L brick sides meets at most floor(L) + 2
  // bricks.
  size_t side = 0;
  for (const Bur& bur : burs) {
    burs_.push_back({bur, KernelBurOf(bur, voxel_m_)});
    double reach =
        2 * std::sqrt(bur.radius_m * bur.radius_m + 0.25 * bur.height_m() * bur.height_m()) +
        2 * kSolidBandVoxels * voxel_m_;
    side = std::max(side, static_cast<size_t>(reach / (kSide * voxel_m_)) + 2);
  }
  touched_.resize(std::min(side * side * side, static_cast<size_t>(spec.brick_count())));
}

void Cutter::Use(size_t bur) noexcept {
  in_use_ = bur;
  has_last_ = lower_complete_ = false;
}

bool Cutter::AnySolidNear(const Pose& pose, double margin_m) const noexcept {
  dmat3 m = pose.orientation.Matrix();
  double height = bur().height_m();
  Bur whole = bur();
  if (whole.shank_radius_m > 0) {
    height += whole.neck_m + kShankLength_m;
    whole = {BurShape::kCylinder, std::max(whole.radius_m, whole.shank_radius_m), height};
  }
  dvec3 middle = pose.tip_m + m[2] * (0.5 * height);
  dvec3 half = HalfExtent(whole, m) + dvec3(margin_m);
  Box box = BricksOf(volume_.spec(), middle - half, middle + half);
  for (int z = box.lo.z; z <= box.hi.z; ++z)
    for (int y = box.lo.y; y <= box.hi.y; ++y)
      for (int x = box.lo.x; x <= box.hi.x; ++x)
        if (min_phi_[static_cast<size_t>(volume_.spec().BrickIndex(ivec3(x, y, z)))] < kPhiLimit)
          return true;
  return false;
}

void Cutter::VisitState(StateArchive& archive) {
  archive(min_phi_, last_, has_last_, lower_complete_);
  touched_count_ = 0;
}

Cutter::Placed Cutter::Place(const Pose& pose) const noexcept {
  const GridSpec& spec = volume_.spec();
  dmat3 m = pose.orientation.Matrix();
  dvec3 middle = pose.tip_m + m[2] * (0.5 * bur().height_m());
  dvec3 half = HalfExtent(bur(), m) + dvec3(kSolidBandVoxels * voxel_m_);
  dvec3 d = (spec.origin_m() - middle) / voxel_m_;
  Placed out;
  // m's columns are the bur's axes in the scene, so its transpose, read row by row here, takes the
  // scene to the bur.
  out.bur_from_sample.first = dvec3(Dot(m[0], d), Dot(m[1], d), Dot(m[2], d));
  for (int i = 0; i < 3; ++i) out.bur_from_sample.steps[i] = dvec3(m[0][i], m[1][i], m[2][i]);
  out.box = BricksOf(spec, middle - half, middle + half);
  return out;
}

bool Cutter::Cut(const Pose& pose, RemovedUnits& removed) noexcept {
  const bool complete = CutLayers(pose, true, true, removed);
  last_ = pose;
  has_last_ = complete;  // what could not be stored must be tried again
  return complete;
}

bool Cutter::CutLower(const Pose& pose, RemovedUnits& removed) noexcept {
  // last_ stays the pose before until both halves are done: the upper bricks have not met this one.
  lower_complete_ = CutLayers(pose, true, false, removed);
  return lower_complete_;
}

bool Cutter::CutUpper(const Pose& pose, RemovedUnits& removed) noexcept {
  const bool complete = CutLayers(pose, false, true, removed);
  last_ = pose;
  has_last_ = complete && lower_complete_;
  return complete;
}

// Eight bricks at a time: cull, and cut those that pass. Culling rests on two bounds, both by
// convexity of the bur's distance d (cutting/README.md, "Which bricks"): no sample of a brick is
// nearer than the tangent at its middle says, and a sample can only change where n(was) . (was -
// is) > 0, "was" being the pose of the last complete cut. Leaving out may therefore never be wrong
// by more than rounding (CutterTest.LeavingOutWhatTheBurMovedAwayFromChangesNothing).
bool Cutter::CutLayers(const Pose& pose, bool lower, bool upper, RemovedUnits& removed) noexcept {
  touched_count_ = 0;
  bool complete = true;
  const GridSpec& spec = volume_.spec();
  const Placed now = Place(pose);
  CullJob cull{};
  cull.across = cull.along = 0;
  // How far a sample can be from its brick's middle. Four corners do: the other four lie opposite.
  for (int corner = 0; corner < 4; ++corner) {
    dvec3 to =
        now.bur_from_sample.steps * dvec3(3.5, corner & 1 ? 3.5 : -3.5, corner & 2 ? 3.5 : -3.5);
    cull.across = std::max(cull.across, static_cast<float>(std::sqrt(to.x * to.x + to.y * to.y)));
    cull.along = std::max(cull.along, static_cast<float>(std::fabs(to.z)));
  }
  // Where a sample was minus where it is, in the bur's frame: the difference of two affine maps,
  // and so one itself. Without a last cut has_motion stays off and every brick counts as new.
  Affine motion{};
  if (has_last_) {
    const Placed before = Place(last_);
    for (int i = 0; i < 3; ++i)
      motion.steps[i] = before.bur_from_sample.steps[i] - now.bur_from_sample.steps[i];
    motion.first = before.bur_from_sample.first - now.bur_from_sample.first;
    // Frobenius norm: no step of a voxel, in any direction, changes the motion by more.
    double turn2 = 0;
    for (int i = 0; i < 3; ++i) turn2 += Dot(motion.steps[i], motion.steps[i]);
    cull.turn = static_cast<float>(std::sqrt(turn2));
    dvec3 d = pose.tip_m - last_.tip_m;
    // The farthest that a sample of a brick in the band can be from the tip: the body, and some
    // eight voxels for the band and half a brick. The tenth that is left to kMaxMotion is for
    // rounding.
    double reach = bur().radius_m + bur().height_m() + 8 * voxel_m_;
    cull.has_motion = std::sqrt(Dot(d, d)) + std::sqrt(turn2) * reach < 0.9 * kMaxMotion * voxel_m_;
  }
  // Both halves compute the same box from the same pose, so no layer is cut twice or left out.
  const int middle = (now.box.lo.z + now.box.hi.z + 1) / 2;
  const int z_lo = lower ? now.box.lo.z : middle, z_hi = upper ? now.box.hi.z : middle - 1;
  for (int z = z_lo; z <= z_hi; ++z) {
    for (int y = now.box.lo.y; y <= now.box.hi.y; ++y) {
      // The row may run past the box, and past the grid at its end (min_phi_ has 7 more for that).
      // Results beyond the box are not looked at.
      for (int x = now.box.lo.x; x <= now.box.hi.x; x += 8) {
        const int row = spec.BrickIndex(ivec3(x, y, z));
        const ivec3 first(x * kSide, y * kSide, z * kSide);
        cull.frame = now.bur_from_sample.At(first);
        if (cull.has_motion) cull.motion = motion.At(first);
        const CullResult pass =
            kernels_.cull(burs_[in_use_].kernel, cull, &min_phi_[static_cast<size_t>(row)]);
        for (int i = 0; i < 8 && x + i <= now.box.hi.x; ++i) {
          if (pass.pieces[i] == 0) continue;
          const int brick = row + i;
          if (!volume_.Materialise(brick)) {
            // The other bricks are cut anyway; has_last_ makes sure that this one is tried again.
            complete = false;
            continue;
          }
          CutBrick(brick,
                   {now.bur_from_sample.At(first + ivec3(8 * i, 0, 0)), pass.pieces[i],
                    min_phi_[static_cast<size_t>(brick)]},
                   removed);
        }
      }
    }
  }
  return complete;
}

void Cutter::CutBrick(int brick, const BrickJob& job, RemovedUnits& removed) noexcept {
  int16_t* phi = volume_.MutablePhi(brick).phi.data();
  const bool mixed = volume_.HasLabels(brick);
  alignas(32) std::array<int16_t, kBrickVoxels> gone;
  const BrickChange change =
      kernels_.cut(burs_[in_use_].kernel, job, phi, mixed ? gone.data() : nullptr);
  min_phi_[static_cast<size_t>(brick)] = static_cast<int16_t>(change.lowest);
  // `gone` is in units of phi, 1/8192 of a voxel.
  if (change.removed != 0 && mixed) {
    const auto& labels = volume_.Labels(brick).tissue;
    for (size_t i = 0; i < kBrickVoxels; ++i) removed[labels[i]] += 8 * int64_t{gone[i]};
  } else {
    removed[static_cast<size_t>(volume_.UniformTissue(brick))] += change.removed;
  }
  if (change.changed) touched_[touched_count_++] = brick;
}

}  // namespace enamel::cutting
