#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>

#include "common/base/mutex.h"

namespace enamel::server::ops {

// Who was refused and why. `kind` is what counts as the same refusal again: a code and a field,
// say; `reason` is for the log's reader and may hold what a peer wrote.
struct Refusal {
  std::string who;
  std::string kind;
  std::string reason;
};

// What was refused at one of the server's doors, said once: the first refusal of a peer for a
// reason makes a line, the same again within the next minute is only counted, and told with the
// next line. Bounded: beyond kMaxPeers peers and reasons the one longest silent is forgotten.
// Thread safety: any thread.
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
