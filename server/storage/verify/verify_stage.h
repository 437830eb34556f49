#pragma once

#include "common/sql/db.h"
#include "server/storage/verify/verify.h"

namespace enamel::server {

// Compares how far each attempt is with what has to be there for it: header, recording, score, runs
// (schemas/audit.md, "How far an attempt is"). That one is quarantined is a decision, which
// CheckAudit compares. Adds to the report's findings.
Status CheckStages(sql::Db& db, VerifyReport& report);

}  // namespace enamel::server
