#include "server/storage/engine/database_look.h"

#include <chrono>

#include "common/base/unix_time.h"

namespace enamel::server {

using std::chrono::steady_clock;
using std::chrono::system_clock;

Result<std::optional<int64_t>> FollowClockOf(sql::Db& db) {
  constexpr int kQuestions = 3;
  struct Reading {
    int64_t theirs_ms;
    steady_clock::duration took;
    steady_clock::time_point at;
  };
  std::optional<Reading> best;
  for (int i = 0; i < kQuestions; ++i) {
    const auto asked = steady_clock::now();
    ENAMEL_ASSIGN_OR_RETURN(const auto theirs_ms, db.ClockMs());
    if (!theirs_ms) return std::optional<int64_t>();
    const auto at = steady_clock::now();
    if (!best || at - asked < best->took) best = Reading{*theirs_ms, at - asked, at};
  }
  // The answer was made somewhere between question and answer: in the middle, as far as one knows.
  const auto then = system_clock::time_point(std::chrono::milliseconds(best->theirs_ms)) +
                    std::chrono::duration_cast<system_clock::duration>(best->took / 2);
  const auto since =
      std::chrono::duration_cast<system_clock::duration>(steady_clock::now() - best->at);
  FollowClock(then + since);
  return std::optional(enamel::UnixMs(system_clock::now()) - enamel::UnixMs(then + since));
}

Status DatabaseLook::Look() {
  if (!rows_.shared()) return Status::Ok();
  return rows_.Read([this](sql::Db& db) -> Status {
    ENAMEL_ASSIGN_OR_RETURN(const auto ahead_ms, FollowClockOf(db));
    clock_ahead_ms_ = ahead_ms.value_or(0);
    ENAMEL_ASSIGN_OR_RETURN(standby_, db.StandbyOf());
    return Status::Ok();
  });
}

bool DatabaseLook::ChangesWait() const {
  return rewriter_.running() || rows_.writer().waits() || standby_ == sql::Standby::kMissing;
}

}  // namespace enamel::server
