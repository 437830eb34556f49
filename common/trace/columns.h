#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/trace/trace.h"

// Payload of a chunk before compression (schemas/trace_format.md, "Payload"): one column per field,
// each as differences of the order that takes the fewest bytes. Pure functions; allocate.
namespace enamel::trace {

inline constexpr size_t kColumnCount = 24;

// Most bytes that `count` ticks can take.
constexpr size_t MaxPayloadBytes(size_t count) { return kColumnCount * (1 + 10 * count); }

// Deterministic: equal ticks give equal bytes, with every compiler and library version.
Bytes EncodeColumns(std::span<const Tick> ticks);

// Errors: kInvalidInput naming the column: early end, bytes left over, order over 3, a value
// outside its field. Requires: count <= kMaxTicksPerChunk.
Result<std::vector<Tick>> DecodeColumns(ByteView payload, size_t count);

}  // namespace enamel::trace
