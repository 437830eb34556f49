#pragma once

#include "common/protocol/messages.h"
#include "common/trace/trace.h"

namespace enamel::test {

// The seal in a station's request.
inline void FillSeal(const trace::Seal& seal, wire::SealAttempt& body) {
  body.set_attempt(protocol::ToField(seal.attempt.view()));
  body.set_chunks(seal.chunks);
  body.set_ticks(seal.ticks);
  body.set_last_chunk(protocol::ToField(seal.last_chunk.view()));
  body.set_state_hash(seal.state_hash);
}

}  // namespace enamel::test
