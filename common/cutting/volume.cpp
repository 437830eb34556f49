#include "common/cutting/volume.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <utility>

#include "common/cutting/brick_kernel.h"

namespace enamel::cutting {
namespace {

constexpr int kShift = 3;  // log2(kBrickSide)

int InBrick(const ivec3& v) noexcept { return ((v.z & 7) << 6) | ((v.y & 7) << 3) | (v.x & 7); }

}  // namespace

Volume::Volume(const GridSpec& spec) : spec_(spec) {
  slot_.assign(static_cast<size_t>(spec.brick_count()), -1);
}

void Volume::SetBrick(int brick, std::span<const int16_t, kBrickVoxels> phi,
                      std::span<const uint8_t> labels, Tissue tissue) {
  auto& slot = slot_[static_cast<size_t>(brick)];
  if (slot < 0) {
    slot = static_cast<int32_t>(phi_.size());
    phi_.Append();
    uniform_.push_back(tissue);
    label_slot_.push_back(-1);
  }
  auto s = static_cast<size_t>(slot);
  std::copy(phi.begin(), phi.end(), phi_[s].phi.begin());
  uniform_[s] = tissue;
  if (labels.empty()) {
    label_slot_[s] = -1;
    return;
  }
  ENAMEL_CHECK(labels.size() == kBrickVoxels);
  if (label_slot_[s] < 0) {
    label_slot_[s] = static_cast<int32_t>(labels_.size());
    labels_.Append();
  }
  std::copy(labels.begin(), labels.end(),
            labels_[static_cast<size_t>(label_slot_[s])].tissue.begin());
}

void Volume::SetUniform(int brick, Tissue tissue) {
  ENAMEL_CHECK(!IsStored(brick));
  slot_[static_cast<size_t>(brick)] = -1 - static_cast<int32_t>(tissue);
}

void Volume::Reserve() {
  size_t more = 0;
  for (int32_t s : slot_) more += s < -1;
  phi_.Reserve(phi_.size() + more);
  phi_.Warm(kWarmBricks, SIZE_MAX);
  labels_.Warm(kWarmLabels, SIZE_MAX);
  uniform_.reserve(uniform_.size() + more);
  label_slot_.reserve(label_slot_.size() + more);
}

size_t Volume::MemoryBytes() const noexcept {
  // 5: a tissue and a label slot for each stored brick.
  return slot_.size() * sizeof(int32_t) + phi_.size() * (sizeof(BrickPhi) + 5) +
         labels_.size() * sizeof(BrickLabels);
}

int16_t Volume::Lowest(int brick) const noexcept {
  const int16_t* phi = Samples(brick);
  return IsStored(brick) ? *std::min_element(phi, phi + kBrickVoxels) : *phi;
}

bool Volume::Materialise(int brick) noexcept {
  auto& slot = slot_[static_cast<size_t>(brick)];
  if (slot >= 0) return true;
  // Three rows grow together; none may allocate in a tick.
  if (slot == -1 || phi_.size() >= phi_.capacity() || uniform_.size() >= uniform_.capacity() ||
      label_slot_.size() >= label_slot_.capacity()) {
    return false;
  }
  uniform_.push_back(static_cast<Tissue>(-1 - slot));
  label_slot_.push_back(-1);
  phi_.Append().phi.fill(-kPhiLimit);
  slot = static_cast<int32_t>(phi_.size() - 1);
  return true;
}

int Volume::PhiAt(const ivec3& v) const noexcept {
  if (v.x < 0 || v.y < 0 || v.z < 0) return kPhiLimit;
  ivec3 b(v.x >> kShift, v.y >> kShift, v.z >> kShift);
  if (!spec_.Contains(b)) return kPhiLimit;
  return SampleIn(spec_.BrickIndex(b), InBrick(v));
}

Tissue Volume::TissueAt(const ivec3& v) const noexcept {
  if (v.x < 0 || v.y < 0 || v.z < 0) return Tissue::kAir;
  ivec3 b(v.x >> kShift, v.y >> kShift, v.z >> kShift);
  if (!spec_.Contains(b)) return Tissue::kAir;
  int brick = spec_.BrickIndex(b);
  if (HasLabels(brick))
    return static_cast<Tissue>(Labels(brick).tissue[static_cast<size_t>(InBrick(v))]);
  return UniformTissue(brick);
}

namespace {

// Of a cell's corners (z, y, x), at shares f of it.
double Trilinear(const double (&c)[2][2][2], const dvec3& f) noexcept {
  auto plane = [&](int z) {
    return (c[z][0][0] * (1 - f.x) + c[z][0][1] * f.x) * (1 - f.y) +
           (c[z][1][0] * (1 - f.x) + c[z][1][1] * f.x) * f.y;
  };
  const double z0 = plane(0), z1 = plane(1);
  return (z0 * (1 - f.z) + z1 * f.z) * (1.0 / kPhiPerVoxel);
}

}  // namespace

double Volume::DistanceAt_m(const dvec3& point_m) const noexcept {
  double h = spec_.voxel_m();
  return DistanceAtSample((point_m - spec_.origin_m()) / h) * h;
}

double Volume::DistanceAtSample(const dvec3& g) const noexcept {
  ivec3 n = spec_.voxels();
  constexpr double kFar = static_cast<double>(kPhiLimit) / kPhiPerVoxel;
  // Written so that what is not a number is far away as well.
  if (!(g.x > -1 && g.y > -1 && g.z > -1 && g.x < n.x && g.y < n.y && g.z < n.z)) return kFar;
  // g > -1, so truncation of g + 1 is floor.
  ivec3 i(static_cast<int>(g.x + 1) - 1, static_cast<int>(g.y + 1) - 1,
          static_cast<int>(g.z + 1) - 1);
  double fx = g.x - i.x, fy = g.y - i.y, fz = g.z - i.z;
  double c[2][2][2];
  if (i.x >= 0 && i.y >= 0 && i.z >= 0 && i.x < n.x - 1 && i.y < n.y - 1 && i.z < n.z - 1) {
    // Bricks of the cell's corners: two along each axis, the same one for most.
    for (int z = 0; z < 2; ++z) {
      for (int y = 0; y < 2; ++y) {
        ivec3 v(i.x, i.y + y, i.z + z);
        int row = spec_.BrickIndex(ivec3(v.x >> kShift, v.y >> kShift, v.z >> kShift)),
            in = InBrick(v);
        c[z][y][0] = SampleIn(row, in);
        c[z][y][1] = (v.x & 7) < 7 ? SampleIn(row, in + 1) : SampleIn(row + 1, in - 7);
      }
    }
  } else {
    for (int z = 0; z < 2; ++z)
      for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 2; ++x) c[z][y][x] = PhiAt(i + ivec3(x, y, z));
  }
  return Trilinear(c, dvec3(fx, fy, fz));
}

const UniformPhi kUniformPhi;

UniformPhi::UniformPhi() noexcept {
  air.fill(kPhiLimit);
  solid.fill(-kPhiLimit);
}

namespace {

using Row = float __attribute__((vector_size(16)));
using RowPhi = int16_t __attribute__((vector_size(16)));
using RowInts = int32_t __attribute__((vector_size(16)));
using RowBits = int64_t __attribute__((vector_size(16)));

Row Splat(float v) noexcept { return Row{v, v, v, v}; }

// What a cut left as air's limit is at least this far away, and by no more than that is known.
constexpr int kKnown = static_cast<int>(kAirBandVoxels * kPhiPerVoxel);
Row Known(const Row& phi) noexcept {
  const Row known = Splat(kKnown);
  return phi < known ? phi : known;
}

// Of three samples along an axis, `first` on: weights of the value at g, and of the change from g - 1/2 to
// g + 1/2. Both ends fall on the same three samples: u past the first and u past the second. The value has
// weights on two of them, near and the next; far is the third. Without branches: none could be foretold.
struct Axis {
  int first, near;
  float u;
  explicit Axis(double g) noexcept
      : first(static_cast<int>(g - 0.5)), near(0), u(static_cast<float>(g - 0.5 - first)) {
    near = u >= 0.5f;
  }
  // Which of the three samples.
  int Next() const noexcept { return near + 1; }
  int Far() const noexcept { return 2 - 2 * near; }
  float ValueNear() const noexcept { return 0.5f - u + static_cast<float>(near); }
  float ValueNext() const noexcept { return 0.5f + u - static_cast<float>(near); }
  float Change(int sample) const noexcept {
    const float change[3] = {u - 1, 1 - 2 * u, u};
    return change[sample];
  }
};

// Sums along x, over a row's first three samples, in their order.
struct AlongX {
  Row value, change;
  explicit AlongX(float u) noexcept {
    const float below = 0.5f - u > 0 ? 0.5f - u : 0, above = u - 0.5f > 0 ? u - 0.5f : 0;
    value = Row{below, 1 - below - above, above, 0};
    change = Row{u - 1, 1 - 2 * u, u, 0};
  }
  static float Sum(const Row& p) noexcept { return p[0] + p[1] + p[2]; }
  float Value(const Row& row) const noexcept { return Sum(row * value); }
  float Change(const Row& row) const noexcept { return Sum(row * change); }
};

// Where a sample along y or z is: which brick beside the first's, and where in it.
struct Place {
  int brick, in;
  Place(int sample, int first, int step, int stride) noexcept
      : brick(((sample >> kShift) - (first >> kShift)) * step),
        in((sample & (kBrickSide - 1)) * stride) {}
};

// Rows of three samples along x.
class Rows {
 public:
  Rows(const Volume& volume, int first_x, int brick) noexcept
      : volume_(volume), brick_(brick), in_x_(first_x & (kBrickSide - 1)) {
    from_ = in_x_ < kBrickSide - 4 ? in_x_ : kBrickSide - 4;
    shift_ = 16 * (in_x_ - from_);
    crosses_ = in_x_ + 3 > kBrickSide;
  }
  // The fourth lane is no sample.
  Row At(const Place& y, const Place& z) const noexcept {
    const int brick = brick_ + y.brick + z.brick, at = y.in + z.in;
    uint64_t bits, next = 0;
    std::memcpy(&bits, volume_.Samples(brick) + at + from_, sizeof bits);
    if (crosses_) std::memcpy(&next, volume_.Samples(brick + 1) + at, sizeof next);
    // Those that the brick has, and those of the brick beside it after them.
    bits = bits >> shift_ | next << 1 << (63 - shift_);
    auto phi = (RowPhi)RowBits{static_cast<int64_t>(bits), 0};
    // Each in the upper half of 32 bits, and shifted down with its sign.
    phi = __builtin_shufflevector(phi, phi, 0, 0, 1, 1, 2, 2, 3, 3);
    return __builtin_convertvector((RowInts)phi >> 16, Row);
  }

 private:
  const Volume& volume_;
  int brick_, in_x_, from_, shift_;
  bool crosses_;
};

bool TwoVoxelsInside(const ivec3& n, const dvec3& g) noexcept {
  return g.x > 2 && g.y > 2 && g.z > 2 && g.x < n.x - 2 && g.y < n.y - 2 && g.z < n.z - 2;
}

}  // namespace

// Rows are summed over y and z as vectors, and along x at the end. Each sample is read once: 12 for the distance
// and 12 for the slope, where seven interpolations read 56.
double Volume::DistanceAndSlope(const dvec3& g, double within, dvec3& slope) const noexcept {
  slope = dvec3(0);
  if (!TwoVoxelsInside(spec_.voxels(), g)) return DistanceAtSample(g);
  const Axis ax(g.x), y(g.y), z(g.z);
  const AlongX x(ax.u);
  const ivec3 first(ax.first, y.first, z.first);
  const Rows rows(*this, first.x,
                  spec_.BrickIndex(ivec3(first.x >> kShift, first.y >> kShift, first.z >> kShift)));
  const int step_y = spec_.bricks.x, step_z = spec_.bricks.x * spec_.bricks.y;
  auto in_y = [&](int sample) { return Place(first.y + sample, first.y, step_y, kBrickSide); };
  auto in_z = [&](int sample) {
    return Place(first.z + sample, first.z, step_z, kBrickSide * kBrickSide);
  };
  const Place y_near = in_y(y.near), y_next = in_y(y.Next());
  const Place z_near = in_z(z.near), z_next = in_z(z.Next());
  const Row c00 = rows.At(y_near, z_near), c10 = rows.At(y_next, z_near);
  const Row c01 = rows.At(y_near, z_next), c11 = rows.At(y_next, z_next);
  const Row y0 = Splat(y.ValueNear()), y1 = Splat(y.ValueNext());
  const Row z0 = Splat(z.ValueNear()), z1 = Splat(z.ValueNext());
  const Row low = c00 * y0 + c10 * y1, high = c01 * y0 + c11 * y1;
  const Row value = low * z0 + high * z1;
  constexpr float kUnit = 1.0f / kPhiPerVoxel;
  const double distance = x.Value(value) * kUnit;
  if (distance >= within) {
    return x.Value((Known(c00) * y0 + Known(c10) * y1) * z0 +
                   (Known(c01) * y0 + Known(c11) * y1) * z1) *
           kUnit;
  }
  const Place y_far = in_y(y.Far()), z_far = in_z(z.Far());
  const Row cy0 = Splat(y.Change(y.near)), cy1 = Splat(y.Change(y.Next())),
            cy2 = Splat(y.Change(y.Far()));
  const Row by_y = (c00 * cy0 + c10 * cy1 + rows.At(y_far, z_near) * cy2) * z0 +
                   (c01 * cy0 + c11 * cy1 + rows.At(y_far, z_next) * cy2) * z1;
  const Row third = rows.At(y_near, z_far) * y0 + rows.At(y_next, z_far) * y1;
  const Row by_z = low * Splat(z.Change(z.near)) + high * Splat(z.Change(z.Next())) +
                   third * Splat(z.Change(z.Far()));
  slope = dvec3(x.Change(value) * kUnit, x.Value(by_y) * kUnit, x.Value(by_z) * kUnit);
  return distance;
}

dvec3 Volume::SlopeAtSample(const dvec3& g) const noexcept {
  dvec3 slope;
  DistanceAndSlope(g, std::numeric_limits<double>::infinity(), slope);
  return slope;
}

double Volume::ClearanceAtSample(const dvec3& g) const noexcept {
  ivec3 n = spec_.voxels();
  if (!(g.x > -0.5 && g.y > -0.5 && g.z > -0.5 && g.x < n.x - 1 && g.y < n.y - 1 && g.z < n.z - 1))
    return 0;
  ivec3 v(static_cast<int>(g.x + 0.5), static_cast<int>(g.y + 0.5), static_cast<int>(g.z + 0.5));
  const int phi =
      SampleIn(spec_.BrickIndex(ivec3(v.x >> kShift, v.y >> kShift, v.z >> kShift)), InBrick(v));
  constexpr double kHalfDiagonal = 0.8661;  // sqrt(3) / 2, rounded up
  return (phi < kKnown ? phi : kKnown) * (1.0 / kPhiPerVoxel) - kHalfDiagonal;
}

Tissue Volume::TissueAtPoint(const dvec3& point_m) const noexcept {
  return TissueAtSample((point_m - spec_.origin_m()) / spec_.voxel_m());
}

Tissue Volume::TissueAtSample(const dvec3& g) const noexcept {
  ivec3 n = spec_.voxels();
  if (!(g.x > -0.5 && g.y > -0.5 && g.z > -0.5 && g.x < n.x && g.y < n.y && g.z < n.z)) {
    return Tissue::kAir;
  }
  return TissueAt(
      ivec3(static_cast<int>(g.x + 0.5), static_cast<int>(g.y + 0.5), static_cast<int>(g.z + 0.5)));
}

bool Volume::operator==(const Volume& other) const {
  if (!(spec_ == other.spec_)) return false;
  for (int b = 0; b < spec_.brick_count(); ++b) {
    if (IsStored(b) != other.IsStored(b)) return false;
    if (!IsStored(b)) {
      if (UniformTissue(b) != other.UniformTissue(b)) return false;
      continue;
    }
    if (Phi(b).phi != other.Phi(b).phi || HasLabels(b) != other.HasLabels(b)) return false;
    if (HasLabels(b) ? Labels(b).tissue != other.Labels(b).tissue
                     : UniformTissue(b) != other.UniformTissue(b)) {
      return false;
    }
  }
  return true;
}

Status ValidateGrid(const GridSpec& spec, size_t max_bytes) {
  if (spec.voxel_nm < 5'000 || spec.voxel_nm > 1'000'000) {
    return Status(Code::kInvalidInput,
                  "expected a voxel size from 0.005 to 1 mm, found " +
                      std::to_string(spec.voxel_nm * 1e-6) + " mm",
                  "voxel_nm");
  }
  for (int i = 0; i < 3; ++i) {
    // 4096 along all three would be too many for an int; the bound on bytes below keeps BrickIndex
    // in it.
    if (spec.bricks[i] < 1 || spec.bricks[i] > 4096) {
      return Status(
          Code::kInvalidInput,
          "expected 1 to 4096 bricks along each axis, found " + std::to_string(spec.bricks[i]),
          "bricks");
    }
    int64_t origin = spec.origin_nm[static_cast<size_t>(i)];
    if (origin < -1'000'000'000 || origin > 1'000'000'000) {
      return Status(Code::kInvalidInput, "expected an origin within 1 m of the scene's",
                    "origin_nm");
    }
  }
  auto needed = static_cast<double>(spec.brick_count()) * (4.0 + sizeof(BrickPhi));
  if (needed > static_cast<double>(max_bytes)) {
    return Status(Code::kTooLarge,
                  "a grid of this size may need " + std::to_string(needed / 1048576.0) +
                      " MiB, allowed are " + std::to_string(max_bytes / 1048576) +
                      " MiB: choose a larger voxel",
                  "voxel_nm");
  }
  return Status::Ok();
}

std::array<double, kTissueCount> SolidVolume_m3(const Volume& volume) {
  std::array<int64_t, kTissueCount> sums{};
  for (int b = 0; b < volume.spec().brick_count(); ++b) {
    auto uniform = static_cast<size_t>(volume.UniformTissue(b));
    if (!volume.IsStored(b)) {
      if (uniform != 0) sums[uniform] += int64_t{kBrickVoxels} * 65536;
      continue;
    }
    const auto& phi = volume.Phi(b).phi;
    const BrickLabels* labels = volume.HasLabels(b) ? &volume.Labels(b) : nullptr;
    for (size_t i = 0; i < kBrickVoxels; ++i) {
      // Integers: the sum is the same in any order and on any machine.
      sums[labels ? labels->tissue[i] : uniform] += SolidFraction(phi[i]);
    }
  }
  double h = volume.spec().voxel_m();
  std::array<double, kTissueCount> out{};
  for (size_t t = 0; t < kTissueCount; ++t)
    out[t] = static_cast<double>(sums[t]) * (h * h * h / 65536.0);
  return out;
}

}  // namespace enamel::cutting
