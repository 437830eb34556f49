#pragma once

#include <optional>

#include "common/sql/db.h"
#include "common/trace/trace.h"
#include "server/storage/audit/audit_row.h"
#include "server/storage/verify/verify.h"

namespace enamel::server {

// Checks the audit trail's signatures, and compares every decision with the trail's last row about
// it (schemas/audit.md). `key`: this server's ticket key; none: signatures are not checked.
// `earlier`: the end of the trail in a backup. Adds to the report's findings and counts.
Status CheckAudit(sql::Db& db, const std::optional<trace::PublicKey>& key,
                  const std::vector<AuditHead>& earlier, VerifyReport& report,
                  const UpkeepProgress& progress);

}  // namespace enamel::server
