#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>

#include "common/base/mutex.h"

namespace enamel::server::ops {

// A refused peer and the reason. `kind` decides which refusals count as the same: a code and a
// field, say. `reason` is for the log's reader and may hold what a peer wrote.
struct Refusal {
  std::string who;
  std::string kind;
  std::string reason;
};

// Logs refusals without repeating them: the first refusal of a peer for a reason makes a line.
// Repeats within the next minute are only counted; the next line has the count. Bounded: beyond
// kMaxPeers peers and reasons the one longest silent is forgotten. Thread safety: any thread.
class RefusalLog {
 public:
  using Clock = std::function<std::chrono::steady_clock::time_point()>;
  using Say = std::function<void(const std::string& line)>;
  static constexpr size_t kMaxPeers = 1024;
  static constexpr std::chrono::seconds kQuiet{60};

  // `door` begins every line. Empty `say` and `clock`: the log of the program, and its clock.
  explicit RefusalLog(std::string door, Say say = {}, Clock clock = {});

  void Note(const Refusal& refusal);

 private:
  struct Seen {
    std::chrono::steady_clock::time_point said;
    uint64_t since = 0;  // more of it, not said yet
  };
  void ForgetOne() ENAMEL_REQUIRES(mutex_);

  const std::string door_;
  const Say say_;
  const Clock clock_;
  Mutex mutex_;
  std::map<std::string, Seen> seen_ ENAMEL_GUARDED_BY(mutex_);  // by peer and kind
};

}  // namespace enamel::server::ops
