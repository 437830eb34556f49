#include "common/surface/brick_meshes.h"

#include "common/base/check.h"
#include "common/surface/brick_block.h"

namespace enamel::surface {

BrickMeshes::BrickMeshes(const cutting::GridSpec& spec)
    : spec_(spec),
      meshes_(static_cast<size_t>(spec.brick_count())),
      fingerprints_(meshes_.size(), kNoSurface),
      is_candidate_(meshes_.size()) {}

void BrickMeshes::ExtractAll(const cutting::Volume& volume) {
  std::vector<int32_t> all(meshes_.size());
  for (size_t b = 0; b < all.size(); ++b) all[b] = static_cast<int32_t>(b);
  Renew(volume, all);
}

std::span<const int32_t> BrickMeshes::Update(const cutting::Volume& volume,
                                             std::span<const int32_t> changed) {
  candidates_.clear();
  for (int32_t brick : changed) {
    ivec3 at(brick % spec_.bricks.x, brick / spec_.bricks.x % spec_.bricks.y,
             brick / (spec_.bricks.x * spec_.bricks.y));
    for (int i = 0; i < 27; ++i) {
      ivec3 b = at + ivec3(i % 3, i / 3 % 3, i / 9) - 1;
      if (!spec_.Contains(b)) continue;
      int near = spec_.BrickIndex(b);
      if (is_candidate_[static_cast<size_t>(near)]) continue;
      is_candidate_[static_cast<size_t>(near)] = 1;
      candidates_.push_back(near);
    }
  }
  for (int32_t brick : candidates_) is_candidate_[static_cast<size_t>(brick)] = 0;
  return Renew(volume, candidates_);
}

std::span<const int32_t> BrickMeshes::Renew(const cutting::Volume& volume,
                                            std::span<const int32_t> bricks) {
  ENAMEL_CHECK(volume.spec() == spec_);
  renewed_.clear();
  Block block;
  for (int32_t brick : bricks) {
    auto b = static_cast<size_t>(brick);
    bool any = Gather(volume, brick, block);
    uint64_t fingerprint = any ? Fingerprint(block) : kNoSurface;
    if (fingerprint == fingerprints_[b]) continue;
    fingerprints_[b] = fingerprint;
    meshes_[b] = any ? ExtractBlock(volume, block) : Mesh();
    renewed_.push_back(brick);
  }
  return renewed_;
}

}  // namespace enamel::surface
