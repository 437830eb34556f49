#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "common/protocol/messages.h"

namespace enamel::server::stations {

// What was refused on the station link, said once: the first refusal of a peer for a reason makes a
// line, the same again within the next minute is only counted, and told with the next line.
// Bounded: beyond kMaxPeers peers and reasons the one longest silent is forgotten. Thread safety:
// any thread.
class RefusalLog {
 public:
  using Clock = std::function<std::chrono::steady_clock::time_point()>;
  using Say = std::function<void(const std::string& line)>;
  static constexpr size_t kMaxPeers = 1024;
  static constexpr std::chrono::seconds kQuiet{60};

  // Empty: the log of the program, and its clock.
  explicit RefusalLog(Say say = {}, Clock clock = {});

  // `station`: its name, empty before it said hello.
  void Note(const std::string& peer, const std::string& station, const wire::Error& error);

 private:
  struct Seen {
    std::chrono::steady_clock::time_point said;
    uint64_t since = 0;  // more of it, not said yet
  };
  void ForgetOne();

  const Say say_;
  const Clock clock_;
  std::mutex mutex_;
  std::map<std::string, Seen> seen_;  // guarded by mutex_; by peer, station and reason
};

}  // namespace enamel::server::stations
