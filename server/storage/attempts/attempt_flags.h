#pragma once

#include <cstdint>
#include <string>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "common/sql/db.h"
#include "server/storage/audit/actor.h"
#include "server/training/types.h"

// Flags on an attempt's row, inside a transaction.
namespace enamel::server {

// Scores and flags change in several places and each raises it, so that no edit overwrites what its
// author has not seen.
Status RaiseRevision(sql::Db& db, const Uuid& attempt);
// The revision rises: an override that was begun before the release was seen is refused.
Status SetReleased(sql::Db& db, const Uuid& attempt, bool released, const Actor& by);
// Sets bits of AttemptFlag that are not set, with an audit row.
Status SetFlags(sql::Db& db, const Uuid& attempt, uint32_t flags, const std::string& reason,
                const Actor& by);
// Sets or clears what a run found. The run has an audit row of its own.
Status PutFlag(sql::Db& db, const Uuid& attempt, AttemptFlag flag, bool found);

}  // namespace enamel::server
