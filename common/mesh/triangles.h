#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/math/vec.h"

namespace enamel::mesh {

// Triangles over shared vertices; whichever unit and frame the holder says.
struct Triangles {
  std::vector<dvec3> vertices;                   // (n x 3)
  std::vector<std::array<uint32_t, 3>> indices;  // counter-clockwise seen from outside
};

// A stretch of a file's triangles with the file's names for it: an OBJ object or group and its
// material, an STL solid. Either may be empty.
struct MeshPart {
  std::string name, material;
  uint32_t first = 0, count = 0;  // triangles
};
struct NamedMesh {
  Triangles mesh;
  std::vector<MeshPart> parts;  // in order; together all triangles, or the first kMaxParts of them
  std::vector<std::string> notes;  // for people: what the reader left out
};

inline constexpr size_t kMaxTriangles = 2'000'000;
inline constexpr size_t kMaxVertices = 3 * kMaxTriangles;
inline constexpr size_t kMaxMeshFile = size_t{256} << 20;

inline constexpr size_t kMaxParts = 1000, kMaxPartName = 100;
inline constexpr size_t kMaxNotes = 8, kMaxNote = 200;

// The format in which the import child writes a mesh: "ENTR", u32 vertices, u32 triangles, u32
// parts, u32 notes, f64 x 3 per vertex, u32 x 3 per triangle; per part u32 first, u32 count, and
// twice u8 length and text; per note u8 length and text. Little-endian. Lives only on a pipe between
// two programs of one build.
Bytes EncodeMesh(const NamedMesh& mesh);
// Bounded; refuses indices out of range and coordinates that are not finite.
Result<NamedMesh> DecodeMesh(ByteView bytes);

// Volume by the divergence theorem; right for closed meshes, positive when oriented outward.
double SignedVolume(const std::vector<dvec3>& vertices,
                    const std::vector<std::array<uint32_t, 3>>& triangles);
double SignedVolume(const Triangles& mesh);
// Bounding box of what the triangles use. Requires: at least one.
void BoxOf(const std::vector<dvec3>& vertices,
           const std::vector<std::array<uint32_t, 3>>& triangles, dvec3& lo, dvec3& hi);
double SurfaceArea(const Triangles& mesh);

}  // namespace enamel::mesh
