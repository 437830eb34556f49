#include <sodium.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "common/base/packed.h"
#include "common/trace/columns.h"
#include "common/trace/layout.h"
#include "common/trace/trace.h"

namespace enamel::trace {
namespace {

// In front of what is signed: a key that signs two kinds of message must not let one pass for the
// other (schemas/trace_format.md, "Ticket").
constexpr std::string_view kChunkDomain = "enamel.trace-chunk.v1";
constexpr size_t kHeadBytes = 90;
constexpr size_t kSignatureBytes = 64;
// 3 % smaller than level 3; level 9 would save another 1 % (chunks of 500 ticks of a simulated cut).
constexpr int kZstdLevel = 5;

// A chunk taken apart; the views point into its bytes.
struct Parts {
  ChunkHead head;
  size_t payload_size = 0;
  ByteView packed;
  ByteView hashed;  // everything before the signature
  ByteView signature;
};

uint32_t SumOfGaps(std::span<const Tick> ticks) {
  uint64_t sum = 0;
  for (const Tick& t : ticks) sum += t.input.gap_ticks;
  // 1000 ticks may each declare up to 2^32 - 1.
  return static_cast<uint32_t>(std::min<uint64_t>(sum, std::numeric_limits<uint32_t>::max()));
}

std::array<uint8_t, kChunkDomain.size() + 32> SignedMessage(const Sha256& hash) {
  std::array<uint8_t, kChunkDomain.size() + 32> out;
  std::copy(kChunkDomain.begin(), kChunkDomain.end(), out.begin());
  std::copy(hash.bytes.begin(), hash.bytes.end(), out.begin() + kChunkDomain.size());
  return out;
}

// From the head, before anything is allocated.
Status CheckSizes(const ChunkHead& head, size_t payload_size) {
  if (head.count < 1 || head.count > kMaxTicksPerChunk) {
    return Status(Code::kInvalidInput,
                  "chunk: expected 1 to " + std::to_string(kMaxTicksPerChunk) + " ticks, found " +
                      std::to_string(head.count),
                  "count");
  }
  if (payload_size > MaxPayloadBytes(head.count)) {
    return TooLarge("payload of a chunk of " + std::to_string(head.count) + " ticks",
                    MaxPayloadBytes(head.count), payload_size);
  }
  return Status::Ok();
}

Result<Parts> TakeApart(ByteView bytes) {
  if (bytes.size() > kMaxChunkBytes) return TooLarge("chunk", kMaxChunkBytes, bytes.size());
  ByteReader in(bytes);
  ENAMEL_RETURN_IF_ERROR(ReadMagic("chunk", kChunkMagic, in));
  if (bytes.size() < kHeadBytes + kSignatureBytes) return EndsEarly("chunk", bytes.size());
  Parts parts;
  ChunkHead& head = parts.head;
  head.attempt = Uuid::FromBytes(in.Raw(16));
  head.seq = in.U32();
  head.first_tick = in.U64();
  head.count = in.U32();
  head.gap_ticks = in.U32();
  head.state_hash = in.U64();
  head.previous = Sha256::FromBytes(in.Raw(32));
  parts.payload_size = in.U32();
  size_t packed_size = in.U32();
  ENAMEL_RETURN_IF_ERROR(CheckSizes(head, parts.payload_size));
  // Exactly: bytes left over would be signed and mean nothing.
  if (packed_size != bytes.size() - kHeadBytes - kSignatureBytes) {
    return WrongSize("chunk with " + std::to_string(packed_size) + " bytes of packed payload",
                     kHeadBytes + packed_size + kSignatureBytes, bytes.size());
  }
  parts.packed = in.Raw(packed_size);
  parts.hashed = bytes.first(in.offset());
  parts.signature = in.Raw(kSignatureBytes);
  return parts;
}

Chunk HeadOf(const Parts& parts) {
  Chunk chunk;
  chunk.head = parts.head;
  chunk.hash = HashSha256(parts.hashed);
  std::copy(parts.signature.begin(), parts.signature.end(), chunk.signature.begin());
  return chunk;
}

}  // namespace

Bytes EncodeChunk(ChunkHead head, std::span<const Tick> ticks, const SecretKey& station_key) {
  ENAMEL_CHECK(!ticks.empty() && ticks.size() <= kMaxTicksPerChunk);
  head.count = static_cast<uint32_t>(ticks.size());
  head.gap_ticks = SumOfGaps(ticks);
  Bytes payload = EncodeColumns(ticks);
  Bytes packed = Pack(payload, kZstdLevel);

  ByteWriter out;
  WriteMagic(kChunkMagic, out);
  out.Raw(head.attempt.view());
  out.U32(head.seq);
  out.U64(head.first_tick);
  out.U32(head.count);
  out.U32(head.gap_ticks);
  out.U64(head.state_hash);
  out.Raw(head.previous.view());
  out.U32(static_cast<uint32_t>(payload.size()));
  out.U32(static_cast<uint32_t>(packed.size()));
  ENAMEL_CHECK(out.size() == kHeadBytes);
  out.Raw(packed);

  // The hash is what the next chunk names as well: one pass over the bytes serves both.
  auto message = SignedMessage(HashSha256(out.bytes()));
  Signature signature;
  crypto_sign_detached(signature.data(), nullptr, message.data(), message.size(),
                       station_key.data());
  out.Raw(signature);
  return out.Take();
}

Result<Chunk> DecodeChunkHead(ByteView bytes) {
  ENAMEL_ASSIGN_OR_RETURN(auto parts, TakeApart(bytes));
  return HeadOf(parts);
}

Result<Chunk> DecodeChunk(ByteView bytes) {
  ENAMEL_ASSIGN_OR_RETURN(auto parts, TakeApart(bytes));
  Chunk chunk = HeadOf(parts);
  ENAMEL_ASSIGN_OR_RETURN(auto payload, Unpack(parts.packed, parts.payload_size, "chunk payload"));
  ENAMEL_ASSIGN_OR_RETURN(auto ticks, DecodeColumns(payload, chunk.head.count));
  chunk.ticks = std::move(ticks);
  // A server adds up the heads without unpacking (DecodeChunkHead): they must not say what ticks do
  // not.
  uint32_t gaps = SumOfGaps(chunk.ticks);
  if (gaps != chunk.head.gap_ticks) {
    return Status(Code::kInvalidInput,
                  "chunk: its head declares " + std::to_string(chunk.head.gap_ticks) +
                      " lost ticks, its ticks add up to " + std::to_string(gaps),
                  "gap_ticks");
  }
  return chunk;
}

bool VerifyChunk(ByteView bytes, const PublicKey& station_key) {
  auto parts = TakeApart(bytes);
  if (!parts.ok()) return false;
  auto message = SignedMessage(HashSha256(parts->hashed));
  return crypto_sign_verify_detached(parts->signature.data(), message.data(), message.size(),
                                     station_key.data()) == 0;
}

}  // namespace enamel::trace
