#pragma once

#include "common/sql/db.h"
#include "server/storage/upkeep_store.h"

namespace enamel::server::sqlite {

// The table `server_identity` (schemas/sql/0020_keys.sql): keeps the fingerprint unless there is one, and
// compares it. In a transaction of either isolation. Errors: kConflict. Private to server/storage.
Status MatchIdentityRow(sql::Db& db, ServerPart part, const Sha256& fingerprint);
// Whether a server has said what it is known by.
Result<bool> HasIdentityRow(sql::Db& db, ServerPart part);

}  // namespace enamel::server::sqlite
