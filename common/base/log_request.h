#pragma once

#include <string>
#include <string_view>

#include "common/base/uuid.h"

namespace enamel {

// Names what this thread is doing, as long as this object lives: every line that the thread logs
// carries the name (common/program/log.h), so that all lines of one request can be found. A nested
// one replaces the outer name. Must not live across a co_await, which may resume in another thread.
class LogRequest {
 public:
  // `id` outlives this.
  explicit LogRequest(std::string_view id);
  ~LogRequest();
  LogRequest(const LogRequest&) = delete;
  LogRequest& operator=(const LogRequest&) = delete;

  // This thread's; empty: none.
  static std::string_view Current();
  // Twelve random digits and letters.
  static std::string NewId();
  // 1 to 64 of A-Z a-z 0-9 . _ -: what others may have named theirs.
  static bool IsId(std::string_view text);

 private:
  const std::string_view before_;
};

// Names the attempt whose recording this thread receives, scores or plays back, as long as this
// object lives: every line that the thread logs carries its id, whichever server or worker of the
// school logs it. Nested and across a co_await as LogRequest. A zero id names none.
class LogAttempt {
 public:
  explicit LogAttempt(const Uuid& id);
  ~LogAttempt();
  LogAttempt(const LogAttempt&) = delete;
  LogAttempt& operator=(const LogAttempt&) = delete;

  // This thread's; empty: none.
  static std::string_view Current();

 private:
  const std::string_view before_;
  const std::string id_;
};

}  // namespace enamel
