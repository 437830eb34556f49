#include <string>

#include "common/trace/trace.h"

namespace enamel::trace {
namespace {

Status Conflict(const std::string& what, const char* field, const std::string& expected,
                const std::string& found) {
  return Status(Code::kConflict, what + ": expected " + field + " " + expected + ", found " + found,
                field);
}

}  // namespace

ChainVerifier::ChainVerifier(const Uuid& attempt, const Sha256& header_hash) : attempt_(attempt) {
  state_.head = header_hash;
}

ChainVerifier::ChainVerifier(const Uuid& attempt, const ChainState& state)
    : attempt_(attempt), state_(state) {}

Status ChainVerifier::Accept(const Chunk& chunk) {
  const ChunkHead& head = chunk.head;
  std::string what = "chunk " + std::to_string(head.seq);
  // The plainest mistake first, for the reader of the refusal: another attempt's chunk fails all
  // four.
  if (head.attempt != attempt_) {
    return Conflict(what, "attempt", attempt_.Text(), head.attempt.Text());
  }
  if (head.seq != state_.next_seq) {
    return Conflict(what, "seq", std::to_string(state_.next_seq), std::to_string(head.seq));
  }
  if (head.first_tick != state_.next_tick) {
    return Conflict(what, "first_tick", std::to_string(state_.next_tick),
                    std::to_string(head.first_tick));
  }
  if (head.previous != state_.head) {
    return Conflict(what, "previous", state_.head.Hex(), head.previous.Hex());
  }
  // Nothing before this line has changed anything: after a refusal the right chunk is still
  // accepted.
  state_.head = chunk.hash;
  state_.next_seq += 1;
  state_.next_tick += head.count;
  state_.state_hash = head.state_hash;
  return Status::Ok();
}

Status ChainVerifier::AcceptSeal(const Seal& seal) const {
  // A seal says nothing that the chain does not say: it may only agree. It is not signed itself,
  // and proves nothing about an end that was cut off together with its chunks
  // (schemas/trace_format.md).
  const Seal fits = MakeSeal();
  if (seal.attempt != fits.attempt) {
    return Conflict("seal", "attempt", fits.attempt.Text(), seal.attempt.Text());
  }
  if (seal.chunks != fits.chunks) {
    return Conflict("seal", "chunks", std::to_string(fits.chunks), std::to_string(seal.chunks));
  }
  if (seal.ticks != fits.ticks) {
    return Conflict("seal", "ticks", std::to_string(fits.ticks), std::to_string(seal.ticks));
  }
  if (seal.last_chunk != fits.last_chunk) {
    return Conflict("seal", "last_chunk", fits.last_chunk.Hex(), seal.last_chunk.Hex());
  }
  if (seal.state_hash != fits.state_hash) {
    return Conflict("seal", "state_hash", std::to_string(fits.state_hash),
                    std::to_string(seal.state_hash));
  }
  return Status::Ok();
}

Seal ChainVerifier::MakeSeal() const {
  return {attempt_, state_.next_seq, state_.next_tick, state_.head, state_.state_hash};
}

}  // namespace enamel::trace
