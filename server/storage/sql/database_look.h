#pragma once

#include <cstdint>
#include <optional>

#include "common/base/result.h"
#include "common/sql/db.h"

namespace enamel::server::sqlite {

// Where the engine has a clock of its own: from now on this process's times are that one's
// (FollowClock, common/base/unix_time.h), within half the time that the quickest of three questions took.
// Gives how many ms this machine's clock is ahead of it; none: the engine's clock is this machine's. Blocks.
// Errors: the database's.
Result<std::optional<int64_t>> FollowClockOf(sql::Db& db);

}  // namespace enamel::server::sqlite
