#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/cutting/volume.h"
#include "common/surface/surface.h"

namespace enamel::surface {

// The surface in one mesh per brick, kept up to date with a volume that is cut. The meshes always
// equal ExtractBrick's, but one is rebuilt only where a corner of a crossed cell has changed. Off
// the tick's thread: allocates. Thread safety: none.
class BrickMeshes {
 public:
  // All empty: as if the volume were air.
  explicit BrickMeshes(const cutting::GridSpec& spec);

  // Rebuilds the meshes of these bricks, each named once, where they are out of date. Returns the
  // rebuilt ones; valid until the next call.
  std::span<const int32_t> Renew(const cutting::Volume& volume, std::span<const int32_t> bricks);
  // The same for all bricks.
  void ExtractAll(const cutting::Volume& volume);
  // Call after the samples of `changed` bricks changed (in any order, repeats allowed): checks them
  // and their 26 neighbours. Returns the bricks whose mesh was rebuilt, each once; valid until the
  // next call. Requires: the volume's grid is the one given at the start.
  std::span<const int32_t> Update(const cutting::Volume& volume, std::span<const int32_t> changed);

  const Mesh& at(int brick) const { return meshes_[static_cast<size_t>(brick)]; }
  // Bricks that the last Update looked at.
  size_t looked_at() const { return candidates_.size(); }

 private:
  cutting::GridSpec spec_;
  std::vector<Mesh> meshes_;
  std::vector<uint64_t> fingerprints_;  // of what the mesh was made from
  std::vector<uint8_t> is_candidate_;
  std::vector<int32_t> candidates_, renewed_;
};

}  // namespace enamel::surface
