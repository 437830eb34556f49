#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/base/uuid.h"
#include "common/core/core.h"
#include "common/hands/hand.h"

// Recordings: header, chain of chunks, seal. Normative text: schemas/trace_format.md.
//    header -> chunk 0 -> chunk 1 -> … -> seal
// Each chunk carries the SHA-256 of what precedes it (chunk 0: of the header, which contains the
// server's ticket) and an Ed25519 signature of the station. Everything is little-endian.
namespace enamel::trace {

inline constexpr uint16_t kTraceVersion = 1;
inline constexpr size_t kMaxTicksPerChunk = 1000;
inline constexpr size_t kMaxChunkBytes = 1 << 20;
inline constexpr size_t kMaxHeaderBytes = 4096;
inline constexpr size_t kMaxSoftwareBytes = 128;

using PublicKey = std::array<uint8_t, 32>;  // Ed25519
using SecretKey = std::array<uint8_t, 64>;  // Ed25519, libsodium's form (seed, public key)
using Signature = std::array<uint8_t, 64>;

// Ed25519 over `domain` and then `content`. The domain names the kind of message, so that a key
// that signs several kinds never has one pass for another ("enamel.attempt-ticket.v1").
Signature SignText(std::string_view domain, ByteView content, const SecretKey& key);
bool VerifyText(std::string_view domain, ByteView content, const Signature& signature,
                const PublicKey& key);

// Permission to make one attempt, signed by the server (Ed25519 over the encoded fields). First
// link of the chain.
struct Ticket {
  Uuid attempt;
  std::array<uint8_t, 16> nonce{};
  Uuid person;
  Uuid station;
  Sha256 exercise;  // content address of the exercise version's JSON
  Sha256 profile;   // content address of the device profile's JSON
  int64_t issued_unix_ms = 0;
  int64_t expires_unix_ms = 0;
  Signature signature{};

  bool operator==(const Ticket&) const = default;
};
Bytes EncodeTicket(const Ticket& ticket);
// Does not check the signature. Errors: kInvalidInput, kVersion.
Result<Ticket> DecodeTicket(ByteView bytes);
void SignTicket(Ticket& ticket, const SecretKey& server_key);
bool VerifyTicket(const Ticket& ticket, const PublicKey& server_key);

// The core's start. The server re-runs from this, the volume blob and the chunks alone.
struct Header {
  Ticket ticket;
  Sha256 scene;   // content address of the scene's JSON
  Sha256 volume;  // content address of the initial volume blob
  core::CoreParams params;
  std::string station_software;  // "enamel-station 0.1.0", at most kMaxSoftwareBytes
  Hand hand;                     // of a kind that is told

  bool operator==(const Header&) const = default;
};
// HashSha256 of the encoded header is the first link: chunk 0's `previous`. Requires: a hand.
Bytes EncodeHeader(const Header& header);
// Accepts only what EncodeHeader writes, so that the hash of a decoded header encoded again is the
// hash of the original. Headers of other core versions are read, to be listed; whoever runs a core
// on one calls core::ValidateParams first. Errors: kInvalidInput, kVersion, kTooLarge.
Result<Header> DecodeHeader(ByteView bytes);

// One recorded tick: the input that is the truth, and the witness beside it.
struct Tick {
  core::TickInput input;
  core::TickWitness witness;

  bool operator==(const Tick&) const = default;
};

// The head of a chunk, readable without decoding its columns.
struct ChunkHead {
  Uuid attempt;
  uint32_t seq = 0;
  uint64_t first_tick = 0;  // index among stepped ticks
  uint32_t count = 0;
  uint32_t gap_ticks = 0;   // sum over the chunk, held at 2^32 - 1
  uint64_t state_hash = 0;  // core's, after the last tick
  Sha256 previous;          // hash of the header or the chunk before

  bool operator==(const ChunkHead&) const = default;
};

// Encodes ticks: columns, differences, zigzag varint, zstd; lossless. Then signs. Not real-time: it
// allocates and fits. head.count and gap_ticks are filled in here. Requires: 1 <= ticks.size() <=
// kMaxTicksPerChunk.
Bytes EncodeChunk(ChunkHead head, std::span<const Tick> ticks, const SecretKey& station_key);

struct Chunk {
  ChunkHead head;
  Sha256 hash;  // of everything before the signature: next chunk's `previous`
  Signature signature{};
  std::vector<Tick> ticks;  // empty after DecodeChunkHead
};
// Head, hash and signature only; sizes checked. Cheap: what ingest does first.
// Errors: kInvalidInput, kVersion, kTooLarge.
Result<Chunk> DecodeChunkHead(ByteView bytes);
// All of it. Bounded in memory by kMaxTicksPerChunk whatever the bytes say. Errors: the same.
Result<Chunk> DecodeChunk(ByteView bytes);
// False for a signature by another key, any changed bit, and bytes that are no chunk.
bool VerifyChunk(ByteView bytes, const PublicKey& station_key);

// End of an attempt.
struct Seal {
  Uuid attempt;
  uint32_t chunks = 0;
  uint64_t ticks = 0;
  Sha256 last_chunk;
  uint64_t state_hash = 0;

  bool operator==(const Seal&) const = default;
};
Bytes EncodeSeal(const Seal& seal);
Result<Seal> DecodeSeal(ByteView bytes);

// The state of a chain after the chunks accepted so far. A server stores it per attempt to continue
// after a restart.
struct ChainState {
  Sha256 head;  // hash of the last chunk, or of the header
  uint32_t next_seq = 0;
  uint64_t next_tick = 0;
  uint64_t state_hash = 0;  // of the last chunk; 0 before the first
};

// Checks order and chain as chunks come in; used by ingest, spool verification and replay alike.
// Thread safety: none.
class ChainVerifier {
 public:
  // From the beginning: `header_hash` is HashSha256 of the encoded header.
  ChainVerifier(const Uuid& attempt, const Sha256& header_hash);
  // From where another verifier stood.
  ChainVerifier(const Uuid& attempt, const ChainState& state);
  // Errors: kConflict with what was expected (attempt, seq, first tick, previous hash) and what was
  // found; nothing is changed then. Signatures are not looked at (VerifyChunk).
  Status Accept(const Chunk& chunk);
  // Errors: kConflict.
  Status AcceptSeal(const Seal& seal) const;
  // The seal that fits what was accepted.
  Seal MakeSeal() const;
  const ChainState& state() const { return state_; }
  uint32_t next_seq() const { return state_.next_seq; }
  uint64_t next_tick() const { return state_.next_tick; }
  const Sha256& head() const { return state_.head; }
  uint64_t state_hash() const { return state_.state_hash; }

 private:
  Uuid attempt_;
  ChainState state_;
};

// A whole trace as one file (spool export, `enamel-station replay`): magic, header, chunks, seal;
// readable after truncation up to the last whole chunk.
struct TraceFile {
  Bytes header;               // as EncodeHeader wrote it
  std::vector<Bytes> chunks;  // as EncodeChunk wrote them
  std::optional<Seal> seal;
  bool truncated = false;  // the file ended inside a record; what is here is whole

  bool operator==(const TraceFile&) const = default;
};
Bytes EncodeTraceFile(const TraceFile& file);
// Splits and checks the records, not their chain (ChainVerifier) nor the signatures. Errors:
// kInvalidInput (with the offset; also when not even the header is whole), kVersion, kTooLarge.
Result<TraceFile> DecodeTraceFile(ByteView bytes);

struct KeyPair {
  PublicKey public_key;
  SecretKey secret_key;
};
// Fresh Ed25519 key pair from the system's random source.
KeyPair NewKeyPair();
// The same pair for the same seed: for keys kept as their seed, and for golden files.
KeyPair KeyPairFromSeed(const std::array<uint8_t, 32>& seed);

}  // namespace enamel::trace
