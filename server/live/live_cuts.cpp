#include "server/live/live_cuts.h"

#include <algorithm>

namespace enamel::server {
namespace {

constexpr int32_t kUm_100nm = 10;

int32_t DownTo(int32_t value, int32_t step) { return value / step - (value % step < 0 ? 1 : 0); }

bool Presses(const core::TickWitness& witness) {
  return core::PressedForce_mn(witness) != std::array<int32_t, 3>{};
}

}  // namespace

void CutColumns::Add(const trace::Chunk& chunk) {
  for (const trace::Tick& tick : chunk.ticks) {
    if (!Presses(tick.witness)) continue;
    const auto& at = tick.witness.anchor_100nm;
    const std::tuple key{DownTo(at[0], kCell_um * kUm_100nm), DownTo(at[1], kCell_um * kUm_100nm),
                         core::BurIn(tick.input.flags)};
    const int32_t um = DownTo(at[2], kStep_um * kUm_100nm) * kStep_um;
    auto column = columns_.find(key);
    if (column == columns_.end()) {
      if (columns_.size() < kMaxColumns) columns_.emplace(key, Lowest{um, chunk.head.seq});
    } else if (um < column->second.um) {
      column->second = {um, chunk.head.seq};
    }
  }
  chunks_ = chunk.head.seq + 1;
}

std::vector<CutColumns::Column> CutColumns::Since(uint32_t from) const {
  std::vector<Column> out;
  for (const auto& [key, lowest] : columns_) {
    const auto& [x, y, bur] = key;
    if (lowest.chunk >= from) out.push_back({x, y, lowest.um, lowest.chunk, bur});
  }
  return out;
}

Status LiveCuts::Read(RecordingRows& recordings, const Uuid& attempt, CutColumns& columns) {
  ENAMEL_ASSIGN_OR_RETURN(const auto recording, recordings.Open(attempt, columns.chunks()));
  while (columns.chunks() < recording.chunks) {
    ENAMEL_ASSIGN_OR_RETURN(const auto bytes, recording.next());
    if (!bytes) return Status(Code::kConflict, "a chunk is missing");
    ENAMEL_ASSIGN_OR_RETURN(const trace::Chunk chunk, trace::DecodeChunk(*bytes));
    if (chunk.head.seq != columns.chunks()) return Status(Code::kConflict, "a chunk is missing");
    columns.Add(chunk);
  }
  return Status::Ok();
}

Result<LiveCuts::Cut> LiveCuts::Get(RecordingRows& recordings, const Uuid& attempt, uint32_t from) {
  MutexLock lock(mutex_);
  Known& known = known_[attempt];
  known.asked = ++asked_;
  if (Status read = Read(recordings, attempt, known.columns); !read.ok()) {
    known_.erase(attempt);
    return read;
  }
  Cut out{known.columns.chunks(), known.columns.Since(from)};
  if (known_.size() > kMaxAttempts) {
    known_.erase(
        std::ranges::min_element(known_, {}, [](const auto& e) { return e.second.asked; }));
  }
  return out;
}

}  // namespace enamel::server
