#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"

// Triangles of a part of a tooth, as a surface timeline holds them (schemas/surface_timeline.md,
// "Meshes"). Bounded, deterministic with one version of the packing library.
// Thread safety: functions, any thread. Not real-time.
namespace enamel::timeline {

struct PartMesh {
  static constexpr uint32_t kSteps = 64;       // in a voxel
  static constexpr uint32_t kMost = 1u << 22;  // vertices, and numbers of strips
  static constexpr uint32_t kNewStrip = ~0u;

  struct Vertex {
    std::array<uint32_t, 3> at{};    // steps, from one voxel before the grid's first sample
    std::array<int8_t, 2> normal{};  // outward, octahedral, /127
    uint8_t tissue = 0;              // just under the surface

    bool operator==(const Vertex&) const = default;
  };
  std::vector<Vertex> vertices;
  // Vertices, and kNewStrip between two strips. In a strip each vertex from the third on makes a
  // triangle with the two before it, unless two of them are the same.
  std::vector<uint32_t> strips;

  // Counter-clockwise seen from outside.
  std::vector<std::array<uint32_t, 3>> Triangles() const;

  bool operator==(const PartMesh&) const = default;
};

// Requires: at most kMost of both; the strips name each vertex, for the first time after those
// before it.
Bytes EncodeMesh(const PartMesh& mesh);
// Errors: kInvalidInput for everything that the document does not allow.
Result<PartMesh> DecodeMesh(ByteView blob);

}  // namespace enamel::timeline
