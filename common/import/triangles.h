#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/math/vec.h"

namespace enamel::import {

// Triangles over shared vertices; whichever unit and frame the holder says.
struct Triangles {
  std::vector<dvec3> vertices;                   // (n x 3)
  std::vector<std::array<uint32_t, 3>> indices;  // counter-clockwise seen from outside
};

inline constexpr size_t kMaxTriangles = 2'000'000;
inline constexpr size_t kMaxVertices = 3 * kMaxTriangles;
inline constexpr size_t kMaxMeshFile = size_t{256} << 20;

// What the import child writes: "ENTR", u32 vertices, u32 triangles, f32 x 3 per vertex,
// u32 x 3 per triangle, little-endian. Lives only on a pipe between two programs of one build.
Bytes EncodeTriangles(const Triangles& mesh);
// Bounded; refuses indices out of range and coordinates that are not finite.
Result<Triangles> DecodeTriangles(ByteView bytes);

// Volume by the divergence theorem; right for closed meshes, positive when oriented outward.
double SignedVolume(const std::vector<dvec3>& vertices,
                    const std::vector<std::array<uint32_t, 3>>& triangles);
double SignedVolume(const Triangles& mesh);
// Bounding box of what the triangles use. Requires: at least one.
void BoxOf(const std::vector<dvec3>& vertices,
           const std::vector<std::array<uint32_t, 3>>& triangles, dvec3& lo, dvec3& hi);
double SurfaceArea(const Triangles& mesh);

}  // namespace enamel::import
