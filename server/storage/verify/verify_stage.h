#pragma once

#include "common/sql/db.h"
#include "server/storage/verify/verify.h"

namespace enamel::server {

// Compares the state of each attempt with its stored parts: header, recording, score, runs
// (schemas/audit.md, "How far an attempt is"). Quarantine is a decision, which CheckAudit compares.
// Adds to the report's findings.
Status CheckStages(sql::Db& db, VerifyReport& report);

}  // namespace enamel::server
