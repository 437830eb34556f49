#include "server/live/live_follower.h"

#include "common/base/stoppable_sleep.h"
#include "common/base/unix_time.h"
#include "common/trace/trace.h"
#include "server/live/chunk_moments.h"

namespace enamel::server {

LiveFollower::LiveFollower(LiveBoard& board, Store& store)
    : board_(board), store_(store), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

void LiveFollower::Run(const std::stop_token& stop) {
  do {
    Look(enamel::UnixMs(), stop);
  } while (!SleepUntilStopped(stop, kLookEvery));
}

void LiveFollower::Look(UnixMs now_ms, const std::stop_token& stop) {
  const auto watched = board_.WatchedNow();
  std::erase_if(followed_, [&](const auto& entry) { return !watched.contains(entry.first); });
  for (const auto& [attempt, newest] : watched) {
    if (stop.stop_requested()) return;
    auto at = followed_.find(attempt);
    const bool heard = newest && now_ms - newest->received_ms < kSilentMs;
    const bool by_station =
        heard && (at == followed_.end() || newest->tick > at->second.shown_tick.value_or(0));
    if (by_station) {
      if (at != followed_.end()) followed_.erase(at);
      continue;
    }
    if (at == followed_.end()) at = followed_.emplace(attempt, Followed{}).first;
    // The log says why; it is tried again at the next look.
    const Status shown = Show(attempt, now_ms, at->second);
    if (!shown.ok() && shown.code() != Code::kNotFound) return;
  }
}

Status LiveFollower::Show(const Uuid& attempt, UnixMs now_ms, Followed& followed) {
  const auto row = store_.attempts.AttemptById(attempt);
  const bool made =
      row.ok() && (row->state == AttemptState::kTicketed || row->state == AttemptState::kRecording);
  if (!made) {
    const bool over = row.ok() || row.status().code() == Code::kNotFound;
    if (over) board_.Remove(attempt);
    return row.status();
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto chunks,
                          store_.recordings.NewestChunks(attempt, followed.next_chunk, kMaxChunks));
  for (const Bytes& bytes : chunks) {
    ENAMEL_ASSIGN_OR_RETURN(const trace::Chunk chunk, trace::DecodeChunk(bytes));
    const std::vector<LiveSample> moments = MomentsOf(chunk, row->station, now_ms);
    followed.next_chunk = chunk.head.seq + 1;
    followed.shown_tick = moments.back().tick;
    board_.Put(moments);
  }
  return Status::Ok();
}

}  // namespace enamel::server
