#include "tests/load/stations/recording.h"

#include "common/base/check.h"

namespace enamel::load {
namespace {

Bytes HeaderFor(const School& school, ByteView ticket, Uuid& attempt) {
  trace::Header header;
  auto decoded = trace::DecodeTicket(ticket);
  ENAMEL_CHECK(decoded.ok());
  header.ticket = *decoded;
  header.scene = school.scene;
  header.volume = school.volume;
  header.params = school.params;
  header.station_software = "enamel-loadgen";
  header.hand.kind = HandKind::kProgram;
  attempt = header.ticket.attempt;
  return trace::EncodeHeader(header);
}

// Any 64 bits will do: nothing is re-run during the load.
uint64_t StateHash(uint32_t seq) { return 0x9e3779b97f4a7c15u * (seq + 1u); }

}  // namespace

Recording::Recording(const School& school, ByteView ticket, const trace::KeyPair& keys,
                     std::vector<Payload> payloads, uint32_t chunks)
    : rate_hz_(school.params.rate_hz),
      header_(HeaderFor(school, ticket, attempt_)),
      payloads_(std::move(payloads)) {
  trace::ChunkHead head;
  head.attempt = attempt_;
  head.previous = HashSha256(header_);
  heads_.reserve(chunks);
  signatures_.reserve(chunks);
  for (uint32_t seq = 0; seq < chunks; ++seq) {
    const Payload& payload = PayloadAt(seq);
    head.seq = seq;
    head.state_hash = StateHash(seq);
    heads_.push_back(EncodeHead(head, payload));
    head.previous = ChunkHash(heads_.back(), payload);
    signatures_.push_back(SignChunk(head.previous, keys.secret_key));
    head.first_tick += payload.count;
  }
  Bytes first = Chunk(0);
  ENAMEL_CHECK(trace::DecodeChunk(first).ok() && trace::VerifyChunk(first, keys.public_key));
}

Bytes Recording::Chunk(uint32_t seq) const {
  const Payload& payload = PayloadAt(seq);
  Bytes out;
  out.reserve(kChunkHeadBytes + payload.packed.size() + kChunkSignatureBytes);
  out.insert(out.end(), heads_[seq].begin(), heads_[seq].end());
  out.insert(out.end(), payload.packed.begin(), payload.packed.end());
  out.insert(out.end(), signatures_[seq].begin(), signatures_[seq].end());
  return out;
}

trace::Seal Recording::SealOf(uint32_t chunks) const {
  trace::Seal seal;
  seal.attempt = attempt_;
  seal.chunks = chunks;
  for (uint32_t seq = 0; seq < chunks; ++seq) seal.ticks += ticks(seq);
  seal.last_chunk = ChunkHash(heads_[chunks - 1], PayloadAt(chunks - 1));
  seal.state_hash = StateHash(chunks - 1);
  return seal;
}

}  // namespace enamel::load
