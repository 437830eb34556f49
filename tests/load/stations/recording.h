#pragma once

#include <memory>
#include <vector>

#include "common/trace/trace.h"
#include "tests/load/school.h"
#include "tests/load/stations/chunk_layout.h"

namespace enamel::load {

// A station's attempt, every chunk chained and signed before the clock starts. Payloads repeat if
// the attempt is longer than their stream; heads and signatures never do. Memory: 154 bytes a chunk
// besides the payloads. Thread safety: const after construction.
class Recording {
 public:
  // Requires: the ticket is whole, payloads are not empty. common/trace decodes the first chunk and
  // checks its signature.
  Recording(const School& school, ByteView ticket, const trace::KeyPair& keys,
            std::vector<Payload> payloads, uint32_t chunks);

  const Uuid& attempt() const { return attempt_; }
  const Bytes& header() const { return header_; }
  double rate_hz() const { return rate_hz_; }
  uint32_t chunks() const { return static_cast<uint32_t>(heads_.size()); }
  uint32_t ticks(uint32_t seq) const { return PayloadAt(seq).count; }
  Bytes Chunk(uint32_t seq) const;
  // Of the first `chunks` chunks; at least one.
  trace::Seal SealOf(uint32_t chunks) const;

 private:
  const Payload& PayloadAt(uint32_t seq) const { return payloads_[seq % payloads_.size()]; }

  Uuid attempt_;
  double rate_hz_;
  Bytes header_;
  std::vector<Payload> payloads_;
  std::vector<HeadBytes> heads_;
  std::vector<trace::Signature> signatures_;
};

}  // namespace enamel::load
