#pragma once

#include <chrono>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

#include "server/live/station_board.h"
#include "server/storage/store.h"

namespace enamel::server {

// Keeps a server's board and the store in step. It writes how far each remark to a chair has come,
// so that a waiting one survives the end of the server. If the school has more servers, it reads
// their remarks and connected stations: a remark reaches the server of its station within
// kLookEvery.
//
// A thread of its own until destroyed, which waits for the store; the board and the store outlive
// it.
class BoardKeeper {
 public:
  static constexpr std::chrono::milliseconds kLookEvery{500};
  // Connections come and go slower than remarks.
  static constexpr int kLinksEvery = 4;  // looks
  // Older remarks belong to no attempt in progress.
  static constexpr UnixMs kRemarksForMs = 24 * 3'600'000;

  // `shared`: the school has more servers.
  BoardKeeper(StationBoard& board, Store& store, bool shared);
  // For tests: no thread; the test calls it.
  struct ByHand {};
  BoardKeeper(StationBoard& board, Store& store, bool shared, ByHand)
      : board_(board), store_(store), shared_(shared) {}

  // What fails is in the store's log, and is done at the next look.
  void LookAtRemarks(UnixMs now_ms);
  void LookAtLinks();

 private:
  void Run(const std::stop_token& stop);
  Status KeepLinks();

  StationBoard& board_;
  Store& store_;
  const bool shared_;
  bool remarks_read_ = false;
  std::optional<std::vector<StationLink>>
      kept_;             // of this server, as the store has it; none: nothing
  std::jthread thread_;  // last: ends first
};

}  // namespace enamel::server
