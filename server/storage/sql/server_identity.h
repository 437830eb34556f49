#pragma once

#include "common/sql/db.h"
#include "server/storage/upkeep_store.h"

namespace enamel::server::sqlite {

// The table `server_identity` (schemas/sql/0020_keys.sql): keeps the fingerprint unless there is one, and
// compares it (UpkeepStore::MatchIdentity). In a transaction of either isolation. Errors: kConflict,
// kNotFound. Private to server/storage.
Status MatchIdentityRow(sql::Db& db, ServerPart part, const std::optional<Sha256>& fingerprint);

}  // namespace enamel::server::sqlite
