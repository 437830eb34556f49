#pragma once

#include <span>
#include <string_view>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/cutting/volume.h"

// The shared parts of blobs that belong to a voxel grid (schemas/volume_blob.md,
// schemas/provenance.md, schemas/surface_timeline.md): their beginning, the grid, and sections
// packed with zstd. Bounded, deterministic. Thread safety: functions, any thread.
namespace enamel::scene {

// Four letters, version and flags: 8 bytes.
void WriteBlobStart(std::string_view letters, uint16_t version, uint16_t flags, ByteWriter& out);
// The flags. `known_flags`: one bit, or 0. Errors: kInvalidInput for other letters or flags;
// kVersion; the message begins with `blob`, the name of the format. Bytes after these 8 are left
// for the caller.
Result<uint16_t> ReadBlobStart(ByteReader& in, std::string_view letters, uint16_t version,
                               uint16_t known_flags, std::string_view blob);

// Voxel, bricks and origin: 40 bytes.
void WriteGrid(const cutting::GridSpec& spec, ByteWriter& out);
// Errors: kInvalidInput for a grid over 4 GiB, one over 1 m away, or one that ends early; the
// message begins with `blob`, what is read.
Result<cutting::GridSpec> ReadGrid(ByteReader& in, std::string_view blob);

// Turns small differences of either sign into small numbers, modulo 2^32.
constexpr uint32_t Zigzag(uint32_t v) { return v << 1 ^ (0 - (v >> 31)); }
constexpr uint32_t Unzigzag(uint32_t v) { return v >> 1 ^ (0 - (v & 1)); }
// Numbers as four planes, their bytes by significance: the high ones pack to almost nothing.
void AppendPlanes(std::span<const uint32_t> values, Bytes& out);
// Value `i` of `count`. Requires: planes.size() >= 4 * count, i < count.
uint32_t FromPlanes(ByteView planes, size_t count, size_t i);

Bytes PackSection(ByteView raw);
// The `size` bytes that a section must hold. Errors: kInvalidInput when it is damaged or claims
// another size; the claim is checked before any memory is taken.
Result<Bytes> UnpackSection(ByteView packed, size_t size, std::string_view blob,
                            std::string_view section);

}  // namespace enamel::scene
