#include "station/spool/recorder.h"

namespace enamel::station {

Recorder::Recorder(Spool& spool, SampleRing& ring, const Uuid& attempt, const Sha256& header_hash,
                   const trace::SecretKey& station_key)
    : Recorder(spool, ring, attempt, trace::ChainState{header_hash, 0, 0, 0}, station_key) {}

Recorder::Recorder(Spool& spool, SampleRing& ring, const Uuid& attempt,
                   const trace::ChainState& place, const trace::SecretKey& station_key,
                   size_t ticks_per_chunk)
    : spool_(spool),
      ring_(ring),
      attempt_(attempt),
      key_(station_key),
      ticks_per_chunk_(ticks_per_chunk),
      state_hash_(place.state_hash),
      first_tick_(place.next_tick),
      previous_(place.head),
      chunks_(place.next_seq),
      ticks_(place.next_tick) {
  open_.reserve(ticks_per_chunk_);
}

Result<bool> Recorder::Pump() {
  bool moved = false;
  Sample sample;
  while (open_.size() < ticks_per_chunk_ && ring_.Pop(sample)) {
    open_.push_back(sample.tick);
    state_hash_ = sample.state_hash;
    moved = true;
  }
  // The window reads it while this thread runs: the number of ticks only in memory.
  held_.store(open_.size(), std::memory_order_release);
  // At most one chunk is open: newer samples stay in the ring, so that a slow disk causes a gap
  // instead of growing memory.
  if (open_.size() == ticks_per_chunk_) ENAMEL_RETURN_IF_ERROR(Spill());
  return moved;
}

Status Recorder::Flush() {
  while (true) {
    ENAMEL_ASSIGN_OR_RETURN(auto moved, Pump());
    if (!moved) break;
  }
  return open_.empty() ? Status::Ok() : Spill();
}

Result<trace::Seal> Recorder::Finish() {
  ENAMEL_RETURN_IF_ERROR(Flush());
  // The seal names the last chunk; without chunks there is no recording to end.
  if (chunks() == 0)
    return Status(Code::kInvalidInput, "not one tick was recorded: nothing to seal");
  trace::Seal seal{attempt_, chunks(), first_tick_, previous_, state_hash_};
  ENAMEL_RETURN_IF_ERROR(spool_.PutSeal(seal));
  return seal;
}

Status Recorder::Spill() {
  // Encoded once and retried unchanged: a chunk that perhaps reached the disk before the error is
  // then the same chunk (PutChunk), not another under its seq.
  if (unspooled_.empty()) {
    trace::ChunkHead head;
    head.attempt = attempt_;
    head.seq = chunks();
    head.first_tick = first_tick_;
    head.state_hash = state_hash_;
    head.previous = previous_;
    unspooled_ = trace::EncodeChunk(head, open_, key_);
  }
  ENAMEL_RETURN_IF_ERROR(spool_.PutChunk(attempt_, unspooled_));
  auto chunk = trace::DecodeChunkHead(unspooled_);
  ENAMEL_CHECK(chunk.ok());
  // Only after it is durable: an earlier failure leaves the chain unchanged.
  previous_ = chunk->hash;
  first_tick_ += open_.size();
  ticks_.store(first_tick_, std::memory_order_release);
  chunks_.fetch_add(1, std::memory_order_release);
  open_.clear();
  held_.store(0, std::memory_order_release);
  unspooled_.clear();
  return Status::Ok();
}

}  // namespace enamel::station
