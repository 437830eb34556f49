#include "common/scene/builder.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <thread>
#include <vector>

namespace enamel::scene {
namespace {

using cutting::GridSpec;
using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::kPhiLimit;
using cutting::Tissue;
using cutting::Volume;

// As far as samples reach before they saturate (volume.h). The margin is one voxel more, so that
// the grid ends in plain air.
constexpr double kBandVoxels = 4;
constexpr double kBrickHalfDiagonalVoxels = 3.5 * 1.7320508075688772;
constexpr int kMarginVoxels = 5;

struct Samples {
  std::array<int16_t, kBrickVoxels> phi;
  std::array<uint8_t, kBrickVoxels> tissue;
};

struct Brick {
  Tissue uniform = Tissue::kAir;
  std::unique_ptr<Samples> stored;
};

size_t InBrick(int x, int y, int z) {
  return static_cast<size_t>((z * kBrickSide + y) * kBrickSide + x);
}

int16_t ToPhi(double distance_m, double voxel_m) {
  double phi = distance_m / voxel_m * cutting::kPhiPerVoxel;
  // NaN counts as air.
  if (!(phi < kPhiLimit)) return kPhiLimit;
  if (!(phi > -kPhiLimit)) return -kPhiLimit;
  return static_cast<int16_t>(std::lround(phi));
}

// Gives air voxels the tissue of a solid neighbour, shell by shell. False when there is no solid.
bool DilateLabels(Samples& s) {
  // Corner to corner is 21 steps: after 24 passes no air is left where there was any solid.
  for (int pass = 0; pass < 3 * kBrickSide; ++pass) {
    // From the pass before, and the highest number of several: the outcome must not depend on the
    // order in which voxels are visited, since equal fields have to give equal bytes.
    auto next = s.tissue;
    bool any_air = false, changed = false;
    for (int z = 0; z < kBrickSide; ++z)
      for (int y = 0; y < kBrickSide; ++y)
        for (int x = 0; x < kBrickSide; ++x) {
          size_t i = InBrick(x, y, z);
          if (s.tissue[i] != 0) continue;
          any_air = true;
          uint8_t t = 0;
          if (x > 0) t = std::max(t, s.tissue[i - 1]);
          if (x < 7) t = std::max(t, s.tissue[i + 1]);
          if (y > 0) t = std::max(t, s.tissue[i - 8]);
          if (y < 7) t = std::max(t, s.tissue[i + 8]);
          if (z > 0) t = std::max(t, s.tissue[i - 64]);
          if (z < 7) t = std::max(t, s.tissue[i + 64]);
          next[i] = t;
          changed |= t != 0;
        }
    s.tissue = next;
    if (!any_air) return true;
    if (!changed) return false;
  }
  return true;
}

class BrickBuilder {
 public:
  BrickBuilder(const GridSpec& spec, std::unique_ptr<BrickField> field)
      : spec_(spec), field_(std::move(field)), h_(spec.voxel_m()) {}

  Brick Build(const ivec3& b) {
    dvec3 corner = spec_.origin_m() + h_ * kBrickSide * dvec3(b);
    // No sample of a brick is farther from its middle than half the diagonal. The middle is
    // requested with 1 % more, so that a field that cuts off at the requested reach still returns
    // more than that.
    double reach = (kBandVoxels + kBrickHalfDiagonalVoxels) * h_;
    FieldSample middle = field_->At(corner + 3.5 * h_, 1.01 * reach);
    if (middle.distance_m > reach) return {};
    if (middle.distance_m < -reach && middle.tissue_margin_m > kBrickHalfDiagonalVoxels * h_) {
      return {middle.tissue, nullptr};
    }
    return SampleAll(corner);
  }

 private:
  Brick SampleAll(const dvec3& corner) {
    auto s = std::make_unique<Samples>();
    field_->Brick(corner, h_, 1.01 * kBandVoxels * h_, samples_);
    for (size_t i = 0; i < kBrickVoxels; ++i) {
      s->phi[i] = ToPhi(samples_[i].distance_m, h_);
      s->tissue[i] = static_cast<uint8_t>(samples_[i].tissue);
    }
    bool one_phi =
        std::all_of(s->phi.begin(), s->phi.end(), [&](int16_t p) { return p == s->phi[0]; });
    if (one_phi && s->phi[0] == kPhiLimit) return {};
    bool one_tissue = std::all_of(s->tissue.begin(), s->tissue.end(),
                                  [&](uint8_t t) { return t == s->tissue[0]; });
    if (one_phi && s->phi[0] == -kPhiLimit && one_tissue && s->tissue[0] != 0) {
      return {static_cast<Tissue>(s->tissue[0]), nullptr};
    }
    DilateLabels(*s);
    return {Tissue::kAir, std::move(s)};
  }

  const GridSpec& spec_;
  std::unique_ptr<BrickField> field_;
  double h_;
  BrickField::Samples samples_;
};

class PointField : public BrickField {
 public:
  explicit PointField(const Field& field) : field_(field) {}
  FieldSample At(const dvec3& point_m, double) override { return field_(point_m); }
  void Brick(const dvec3& corner_m, double voxel_m, double, BrickField::Samples& out) override {
    for (int z = 0; z < kBrickSide; ++z)
      for (int y = 0; y < kBrickSide; ++y)
        for (int x = 0; x < kBrickSide; ++x)
          out[InBrick(x, y, z)] = field_(corner_m + voxel_m * dvec3(x, y, z));
  }

 private:
  const Field& field_;
};

uint8_t AnyLabel(const Brick& brick) {
  if (!brick.stored) return static_cast<uint8_t>(brick.uniform);
  return brick.stored->tissue[0];
}

// Bricks that hold only the air side of a surface take the label of a neighbour brick.
void LabelAirBricks(const GridSpec& spec, std::vector<Brick>& bricks) {
  for (int z = 0; z < spec.bricks.z; ++z)
    for (int y = 0; y < spec.bricks.y; ++y)
      for (int x = 0; x < spec.bricks.x; ++x) {
        Brick& brick = bricks[static_cast<size_t>(spec.BrickIndex({x, y, z}))];
        if (!brick.stored || brick.stored->tissue[0] != 0) continue;
        uint8_t found = 0;
        for (int i = 0; i < 27 && found == 0; ++i) {
          ivec3 n(x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1);
          if (spec.Contains(n)) found = AnyLabel(bricks[static_cast<size_t>(spec.BrickIndex(n))]);
        }
        // No solid around: a field that says air inside; the material does not matter then.
        brick.stored->tissue.fill(found != 0 ? found : static_cast<uint8_t>(Tissue::kGypsum));
      }
}

Volume Assemble(const GridSpec& spec, const std::vector<Brick>& bricks) {
  Volume volume(spec);
  for (size_t i = 0; i < bricks.size(); ++i) {
    auto b = static_cast<int>(i);
    if (!bricks[i].stored) {
      volume.SetUniform(b, bricks[i].uniform);
      continue;
    }
    const Samples& s = *bricks[i].stored;
    bool one_tissue =
        std::all_of(s.tissue.begin(), s.tissue.end(), [&](uint8_t t) { return t == s.tissue[0]; });
    // Labels only where a brick holds two tissues: they are half as large as the samples.
    std::span<const uint8_t> labels;
    if (!one_tissue) labels = s.tissue;
    volume.SetBrick(b, s.phi, labels, static_cast<Tissue>(s.tissue[0]));
  }
  return volume;
}

}  // namespace

Volume BuildVolume(const GridSpec& spec,
                   const std::function<std::unique_ptr<BrickField>()>& make_field, int threads,
                   const std::function<void(double)>& progress) {
  std::vector<Brick> bricks(static_cast<size_t>(spec.brick_count()));
  // Layers are taken from one counter, so that no thread waits for a slow one. Bricks know nothing
  // of each other until all are there: who made which does not matter.
  std::atomic<int> next_layer{0};
  auto work = [&](bool reports) {
    BrickBuilder builder(spec, make_field());
    for (int z; (z = next_layer.fetch_add(1)) < spec.bricks.z;) {
      for (int y = 0; y < spec.bricks.y; ++y)
        for (int x = 0; x < spec.bricks.x; ++x) {
          bricks[static_cast<size_t>(spec.BrickIndex({x, y, z}))] = builder.Build({x, y, z});
        }
      if (reports && progress) progress(static_cast<double>(z + 1) / spec.bricks.z);
    }
  };
  std::vector<std::thread> others;
  for (int t = 1; t < threads; ++t) others.emplace_back(work, false);
  work(true);
  for (std::thread& t : others) t.join();
  LabelAirBricks(spec, bricks);
  return Assemble(spec, bricks);
}

Volume BuildVolume(const GridSpec& spec, const Field& field, int threads,
                   const std::function<void(double)>& progress) {
  return BuildVolume(
      spec, [&field] { return std::make_unique<PointField>(field); }, threads, progress);
}

GridSpec GridAround(const dvec3& lo_m, const dvec3& hi_m, int32_t voxel_nm) {
  GridSpec spec;
  spec.voxel_nm = voxel_nm;
  for (int i = 0; i < 3; ++i) {
    auto lo = static_cast<int64_t>(std::floor(lo_m[i] * 1e9 / voxel_nm)) - kMarginVoxels;
    auto hi = static_cast<int64_t>(std::ceil(hi_m[i] * 1e9 / voxel_nm)) + kMarginVoxels;
    // On a lattice through the scene's origin: scenes of one voxel size have their samples in
    // common.
    spec.origin_nm[static_cast<size_t>(i)] = lo * voxel_nm;
    spec.bricks[i] = static_cast<int>((hi - lo) / kBrickSide + 1);
  }
  return spec;
}

void CopyBrick(const Volume& from, int brick, Volume& to) {
  if (!from.IsStored(brick)) {
    to.SetUniform(brick, from.UniformTissue(brick));
  } else if (from.HasLabels(brick)) {
    const auto& labels = from.Labels(brick).tissue;
    to.SetBrick(brick, from.Phi(brick).phi, labels, static_cast<Tissue>(labels[0]));
  } else {
    to.SetBrick(brick, from.Phi(brick).phi, {}, from.UniformTissue(brick));
  }
}

int BuildThreads() {
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 8);
}

}  // namespace enamel::scene
