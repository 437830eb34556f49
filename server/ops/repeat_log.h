#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "common/base/mutex.h"

namespace enamel::server::ops {

// Logs warnings without repeating them: what others can cause as often as they like would fill the
// log. The first of a key makes a line. Repeats within the next minute are only counted; the next
// line has the count. Bounded: beyond kMaxKeys keys the one longest silent is forgotten. Thread
// safety: any thread.
class RepeatLog {
 public:
  using Clock = std::function<std::chrono::steady_clock::time_point()>;
  using Say = std::function<void(const std::string& line)>;
  static constexpr size_t kMaxKeys = 1024;
  static constexpr std::chrono::seconds kQuiet{60};

  // Empty: the log of the program, and its clock.
  explicit RepeatLog(Say say = {}, Clock clock = {});

  // `line` may hold what a peer wrote; it stays one line of the log.
  void Note(const std::string& key, std::string line);

 private:
  struct Seen {
    std::chrono::steady_clock::time_point said;
    uint64_t since = 0;  // more of it, not said yet
  };
  void ForgetOne() ENAMEL_REQUIRES(mutex_);

  const Say say_;
  const Clock clock_;
  Mutex mutex_;
  std::map<std::string, Seen> seen_ ENAMEL_GUARDED_BY(mutex_);  // by key
};

}  // namespace enamel::server::ops
