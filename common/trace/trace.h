#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/core/core.h"

// Recordings: header, chain of chunks, seal. Normative text: schemas/trace_format.md.
//   header -> chunk 0 -> chunk 1 -> … -> seal
// Each chunk carries the SHA-256 of what stands before it (chunk 0: of the header, which contains the
// server's ticket) and an Ed25519 signature of the station. Everything is little-endian.
namespace enamel::trace {

inline constexpr uint16_t kTraceVersion = 1;
inline constexpr size_t kMaxTicksPerChunk = 1000;
inline constexpr size_t kMaxChunkBytes = 1 << 20;

using PublicKey = std::array<uint8_t, 32>;   // Ed25519
using SecretKey = std::array<uint8_t, 64>;   // Ed25519, libsodium's form (seed, public key)
using Signature = std::array<uint8_t, 64>;

// Permission to make one attempt, signed by the server (Ed25519 over the encoded fields). First link
// of the chain.
struct Ticket {
  Uuid attempt;
  std::array<uint8_t, 16> nonce{};
  Uuid person;
  Uuid station;
  Sha256 exercise;          // content address of the exercise version's JSON
  Sha256 profile;           // content address of the device profile's JSON
  int64_t issued_unix_ms = 0;
  int64_t expires_unix_ms = 0;
  Signature signature{};
};
Bytes EncodeTicket(const Ticket& ticket);
Result<Ticket> DecodeTicket(ByteView bytes);
void SignTicket(Ticket& ticket, const SecretKey& server_key);
bool VerifyTicket(const Ticket& ticket, const PublicKey& server_key);

// What the core was started with. The server re-runs from this, the volume blob and the chunks alone.
struct Header {
  Ticket ticket;
  Sha256 scene;             // content address of the scene's JSON
  Sha256 volume;            // content address of the initial volume blob
  core::CoreParams params;
  std::string station_software;   // "enamel-station 0.1.0"
};
Bytes EncodeHeader(const Header& header);
Result<Header> DecodeHeader(ByteView bytes);

// One recorded tick: the input that is the truth, and the witness beside it.
struct Tick {
  core::TickInput input;
  core::TickWitness witness;
};

// What a chunk says about itself, readable without decoding its columns.
struct ChunkHead {
  Uuid attempt;
  uint32_t seq = 0;
  uint64_t first_tick = 0;       // index among stepped ticks
  uint32_t count = 0;
  uint32_t gap_ticks = 0;        // sum over the chunk
  uint64_t state_hash = 0;       // core's, after the last tick
  Sha256 previous;               // hash of the header or the chunk before
};

// Encodes ticks: columns, delta, zigzag varint, zstd; lossless. Then signs.
// Requires: 1 <= ticks.size() <= kMaxTicksPerChunk, head.count and gap_ticks are filled in here.
Bytes EncodeChunk(ChunkHead head, std::span<const Tick> ticks, const SecretKey& station_key);

struct Chunk {
  ChunkHead head;
  Sha256 hash;                   // of everything before the signature: next chunk's `previous`
  Signature signature{};
  std::vector<Tick> ticks;       // empty after DecodeChunkHead
};
// Head, hash and signature only; sizes checked. Cheap: what ingest does first.
Result<Chunk> DecodeChunkHead(ByteView bytes);
// All of it. Bounded in memory by kMaxTicksPerChunk whatever the bytes say.
Result<Chunk> DecodeChunk(ByteView bytes);
bool VerifyChunk(ByteView bytes, const PublicKey& station_key);

// End of an attempt.
struct Seal {
  Uuid attempt;
  uint32_t chunks = 0;
  uint64_t ticks = 0;
  Sha256 last_chunk;
  uint64_t state_hash = 0;
};

// Checks order and chain as chunks come in; used by ingest, spool verification and replay alike.
// Thread safety: none.
class ChainVerifier {
 public:
  ChainVerifier(const Uuid& attempt, const Sha256& header_hash);
  // Errors: kConflict with what was expected (seq, first tick, previous hash) and what was found.
  Status Accept(const Chunk& chunk);
  Status AcceptSeal(const Seal& seal) const;
  uint32_t next_seq() const { return next_seq_; }
  uint64_t next_tick() const { return next_tick_; }
  const Sha256& head() const { return previous_; }
  uint64_t state_hash() const { return state_hash_; }

 private:
  Uuid attempt_;
  Sha256 previous_;
  uint32_t next_seq_ = 0;
  uint64_t next_tick_ = 0;
  uint64_t state_hash_ = 0;
};

// A whole trace as one file (spool export, `enamel-station replay`): magic, header, chunks, seal;
// readable after truncation up to the last whole chunk.
struct TraceFile {
  Bytes header;
  std::vector<Bytes> chunks;
  std::optional<Seal> seal;
  bool truncated = false;
};
Bytes EncodeTraceFile(const TraceFile& file);
Result<TraceFile> DecodeTraceFile(ByteView bytes);

// Fresh Ed25519 key pair from the system's random source.
struct KeyPair { PublicKey public_key; SecretKey secret_key; };
KeyPair NewKeyPair();

}  // namespace enamel::trace
