#include "common/scene/preparation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <span>

#include "common/scene/builder.h"

namespace enamel::scene {
namespace {

using cutting::GridSpec;
using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::kPhiLimit;
using cutting::Tissue;
using cutting::Volume;

double PartDistance_m(const PreparationPart& part, const dvec3& p) {
  dvec3 d = p - dvec3(part.top_um[0], part.top_um[1], part.top_um[2]) * 1e-6;
  double hx = part.half_size_um[0] * 1e-6, hy = part.half_size_um[1] * 1e-6;
  // There is no upper end: the part goes on upward, so that nothing of the tooth is left above it.
  double below = -d.z - part.depth_um * 1e-6;
  double side;
  if (part.outline == PreparationPart::Outline::kDisc) {
    side = std::sqrt(d.x * d.x + d.y * d.y) - hx;
  } else {
    double x = std::abs(d.x) - hx, y = std::abs(d.y) - hy;
    double ox = std::max(x, 0.0), oy = std::max(y, 0.0);
    side = std::sqrt(ox * ox + oy * oy) + std::min(std::max(x, y), 0.0);
  }
  // Outline and floor put together as two half spaces are: outside by Pythagoras, inside the
  // nearer.
  double ox = std::max(side, 0.0), oz = std::max(below, 0.0);
  return std::sqrt(ox * ox + oz * oz) + std::min(std::max(side, below), 0.0);
}

int16_t Hollowed(int phi, double distance_m, double voxel_m) {
  double limit = kPhiLimit;
  // The hollow's inside is the tooth's air, hence the sign.
  double hollow = std::clamp(-distance_m / voxel_m * cutting::kPhiPerVoxel, -limit, limit);
  return static_cast<int16_t>(std::max(phi, static_cast<int>(std::lround(hollow))));
}

// Nothing of the preparation comes within the band of any of the brick's samples.
bool IsFar(const Preparation& preparation, const GridSpec& spec, const dvec3& corner) {
  constexpr double kHalfDiagonalVoxels = 3.5 * 1.7320508075688772, kBandVoxels = 4;
  double h = spec.voxel_m();
  return PreparationDistance_m(preparation, corner + 3.5 * h) >
         (kHalfDiagonalVoxels + kBandVoxels) * h;
}

void HollowBrick(const Volume& from, int brick, const dvec3& corner, const Preparation& preparation,
                 Volume& to) {
  double h = from.spec().voxel_m();
  std::array<int16_t, kBrickVoxels> phi;
  for (int i = 0; i < kBrickVoxels; ++i) {
    dvec3 p = corner + h * dvec3(i % kBrickSide, i / kBrickSide % kBrickSide, i / 64);
    int before = from.IsStored(brick) ? from.Phi(brick).phi[static_cast<size_t>(i)] : -kPhiLimit;
    phi[static_cast<size_t>(i)] = Hollowed(before, PreparationDistance_m(preparation, p), h);
  }
  if (std::all_of(phi.begin(), phi.end(), [](int16_t v) { return v == kPhiLimit; })) return;
  std::span<const uint8_t> labels;
  if (from.HasLabels(brick)) labels = from.Labels(brick).tissue;
  to.SetBrick(brick, phi, labels,
              labels.empty() ? from.UniformTissue(brick) : static_cast<Tissue>(labels[0]));
}

}  // namespace

double PreparationDistance_m(const Preparation& preparation, const dvec3& point_m) {
  double d = PartDistance_m(preparation.parts.at(0), point_m);
  for (const PreparationPart& part : preparation.parts)
    d = std::min(d, PartDistance_m(part, point_m));
  return d;
}

Volume Prepared(const Volume& volume, const Preparation& preparation) {
  const GridSpec& spec = volume.spec();
  Volume out(spec);
  for (int z = 0; z < spec.bricks.z; ++z)
    for (int y = 0; y < spec.bricks.y; ++y)
      for (int x = 0; x < spec.bricks.x; ++x) {
        int brick = spec.BrickIndex({x, y, z});
        bool air = !volume.IsStored(brick) && volume.UniformTissue(brick) == Tissue::kAir;
        dvec3 corner = spec.origin_m() + spec.voxel_m() * kBrickSide * dvec3(x, y, z);
        if (air || IsFar(preparation, spec, corner)) {
          CopyBrick(volume, brick, out);
        } else {
          HollowBrick(volume, brick, corner, preparation, out);
        }
      }
  return out;
}

CavityTarget BoundingTarget(const Preparation& preparation) {
  CavityTarget target;
  target.landmark = preparation.name;
  const PreparationPart& first = preparation.parts.at(0);
  // Symmetric about the landmark, which is the first part's opening.
  for (const PreparationPart& part : preparation.parts) {
    for (size_t i = 0; i < 2; ++i) {
      target.half_size_um[i] =
          std::max(target.half_size_um[i],
                   std::abs(part.top_um[i] - first.top_um[i]) + part.half_size_um[i]);
    }
    target.depth_um = std::max(target.depth_um, first.top_um[2] - part.top_um[2] + part.depth_um);
  }
  return target;
}

}  // namespace enamel::scene
