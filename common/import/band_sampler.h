#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/cutting/volume.h"
#include "common/mesh/triangle_tree.h"

namespace enamel::import {

// Distances from all samples of a brick at once: the triangles near the brick are found once, and
// each is measured against rows of eight samples that it may still be nearest to. Single precision
// relative to the brick's middle: within 1e-6 of the distance and of the triangle's extent from
// there (tested against the tree's double precision). One per thread.
class BandSampler {
 public:
  using Samples = std::array<float, cutting::kBrickVoxels>;  // (z, y, x), x fastest

  explicit BandSampler(const mesh::TriangleTree& tree) : tree_(&tree) {}

  // Unsigned distances, at most `limit`, to the tree's triangles. Samples at corner + h * (i, j,
  // k).
  void Distances(const dvec3& corner, double h, double limit, Samples& out);

 private:
  const mesh::TriangleTree* tree_;
  std::vector<uint32_t> near_;
};

// Which samples of a brick are inside, given each one's distance to the surface. Two samples are on
// one side when no surface fits between them (the sum of their distances exceeds their own).
// `inside` is called once for each group that is connected in this way.
template <typename Inside>
void SidesOf(const dvec3& corner, double h, const BandSampler::Samples& distance,
             const Inside& inside, std::array<bool, cutting::kBrickVoxels>& out) {
  constexpr int kSide = cutting::kBrickSide;
  std::array<bool, cutting::kBrickVoxels> known{};
  std::array<int16_t, cutting::kBrickVoxels> open;
  const auto step = static_cast<float>(h * (1 + 1e-4));
  for (int seed = 0; seed < cutting::kBrickVoxels; ++seed) {
    if (known[static_cast<size_t>(seed)]) continue;
    const bool side =
        inside(corner + h * dvec3(seed % kSide, seed / kSide % kSide, seed / (kSide * kSide)));
    size_t top = 0;
    auto enter = [&](int i) {
      known[static_cast<size_t>(i)] = true;
      out[static_cast<size_t>(i)] = side;
      open[top++] = static_cast<int16_t>(i);
    };
    enter(seed);
    while (top > 0) {
      const int i = open[--top];
      const float own = distance[static_cast<size_t>(i)];
      auto reach = [&](int n) {
        if (!known[static_cast<size_t>(n)] && own + distance[static_cast<size_t>(n)] > step)
          enter(n);
      };
      const int x = i % kSide, y = i / kSide % kSide, z = i / (kSide * kSide);
      if (x > 0) reach(i - 1);
      if (x < kSide - 1) reach(i + 1);
      if (y > 0) reach(i - kSide);
      if (y < kSide - 1) reach(i + kSide);
      if (z > 0) reach(i - kSide * kSide);
      if (z < kSide - 1) reach(i + kSide * kSide);
    }
  }
}

}  // namespace enamel::import
