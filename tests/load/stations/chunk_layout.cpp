#include "tests/load/stations/chunk_layout.h"

#include <sodium.h>

#include <algorithm>

#include "common/base/check.h"

namespace enamel::load {
namespace {

constexpr std::string_view kDomain = "enamel.trace-chunk.v1";

}  // namespace

Payload PayloadOf(ByteView chunk) {
  ENAMEL_CHECK(chunk.size() > kChunkHeadBytes + kChunkSignatureBytes);
  ByteReader in(chunk);
  in.Raw(4 + 2 + 16 + 4 + 8);
  Payload out;
  out.count = in.U32();
  out.gap_ticks = in.U32();
  in.Raw(8 + 32);
  out.unpacked_size = in.U32();
  ByteView packed = in.Raw(in.U32());
  out.packed.assign(packed.begin(), packed.end());
  return out;
}

HeadBytes EncodeHead(const trace::ChunkHead& head, const Payload& payload) {
  ByteWriter out;
  out.Raw(AsBytes("ENac"));
  out.U16(1);
  out.Raw(head.attempt.view());
  out.U32(head.seq);
  out.U64(head.first_tick);
  out.U32(payload.count);
  out.U32(payload.gap_ticks);
  out.U64(head.state_hash);
  out.Raw(head.previous.view());
  out.U32(payload.unpacked_size);
  out.U32(static_cast<uint32_t>(payload.packed.size()));
  ENAMEL_CHECK(out.size() == kChunkHeadBytes);
  HeadBytes bytes;
  std::ranges::copy(out.bytes(), bytes.begin());
  return bytes;
}

Sha256 ChunkHash(const HeadBytes& head, const Payload& payload) {
  Sha256 hash;
  crypto_hash_sha256_state state;
  crypto_hash_sha256_init(&state);
  crypto_hash_sha256_update(&state, head.data(), head.size());
  crypto_hash_sha256_update(&state, payload.packed.data(), payload.packed.size());
  crypto_hash_sha256_final(&state, hash.bytes.data());
  return hash;
}

trace::Signature SignChunk(const Sha256& hash, const trace::SecretKey& key) {
  Bytes message(kDomain.begin(), kDomain.end());
  message.insert(message.end(), hash.bytes.begin(), hash.bytes.end());
  trace::Signature signature;
  crypto_sign_detached(signature.data(), nullptr, message.data(), message.size(), key.data());
  return signature;
}

}  // namespace enamel::load
