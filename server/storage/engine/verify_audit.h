#pragma once

#include <optional>

#include "common/trace/trace.h"
#include "server/storage/engine/verify.h"
#include "server/storage/sql/sqlite_impl.h"

namespace enamel::server::sqlite {

// Compares the audit trail with its signatures, and everything that people decide about with what
// the trail's last row about it states (schemas/audit.md). `key`: this server's ticket key; none:
// signatures are not looked at. `earlier`: where the trail ended in a backup. Adds to the report's
// findings and counts.
Status CheckAudit(Db& db, const std::optional<trace::PublicKey>& key,
                  const std::vector<AuditHead>& earlier, VerifyReport& report,
                  const UpkeepProgress& progress);

}  // namespace enamel::server::sqlite
