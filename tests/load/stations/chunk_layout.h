#pragma once

#include "common/trace/trace.h"
#include "tests/load/stations/motion.h"

namespace enamel::load {

// Splits and assembles chunks by schemas/trace_format.md ("Chunk") alone, so that one encoded
// payload can be used at many places of a chain.
inline constexpr size_t kChunkHeadBytes = 90;
inline constexpr size_t kChunkSignatureBytes = 64;

using HeadBytes = std::array<uint8_t, kChunkHeadBytes>;

Payload PayloadOf(ByteView chunk);
// `head.count` and `head.gap_ticks` are the payload's.
HeadBytes EncodeHead(const trace::ChunkHead& head, const Payload& payload);
Sha256 ChunkHash(const HeadBytes& head, const Payload& payload);
trace::Signature SignChunk(const Sha256& hash, const trace::SecretKey& key);

}  // namespace enamel::load
