#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <stop_token>
#include <thread>

#include "server/live/live_board.h"
#include "server/storage/store.h"

namespace enamel::server {

// Shows on this server's board the attempts that are watched here while their stations upload to
// another server. Every kLookEvery it reads the chunks committed since. A viewer sees a moment at
// most that much after its chunk was committed. Without viewers it reads nothing.
//
// A thread of its own until destroyed, which waits for the store; the board and the store outlive
// it.
class LiveFollower {
 public:
  static constexpr std::chrono::milliseconds kLookEvery{500};
  // A board that has heard of an attempt within this time hears of it from its station.
  static constexpr UnixMs kSilentMs = 1000;
  // Of one that is far behind only the newest chunks: the board keeps a second's rows.
  static constexpr uint32_t kMaxChunks = 3;

  LiveFollower(LiveBoard& board, Store& store);
  // For tests: no thread; the test calls it.
  struct ByHand {};
  LiveFollower(LiveBoard& board, Store& store, ByHand) : board_(board), store_(store) {}

  // Reads once for all watched attempts; ends early when the store fails, or on a stop.
  void Look(UnixMs now_ms, const std::stop_token& stop = {});

 private:
  struct Followed {
    uint32_t next_chunk = 0;
    std::optional<uint64_t> shown_tick;  // the newest that came from here
  };
  void Run(const std::stop_token& stop);
  Status Show(const Uuid& attempt, UnixMs now_ms, Followed& followed);

  LiveBoard& board_;
  Store& store_;
  std::map<Uuid, Followed> followed_;  // the thread's
  std::jthread thread_;                // last: ends first
};

}  // namespace enamel::server
