#pragma once

#include <functional>
#include <optional>

#include "common/sql/db.h"
#include "common/trace/trace.h"
#include "server/storage/verify/verify.h"

namespace enamel::server {

// Compares every result with its signed document (schemas/result.md), the document with the
// recording, the exercise and the reference it names, and the newest with the attempt's row and the
// audit trail. `key`: this server's ticket key; none: signatures are compared with the key that
// each document names. Adds to the report's findings and counts. Whether blobs have their hashes is
// not looked at here.
Status CheckResults(sql::Db& db, const std::optional<trace::PublicKey>& key, VerifyReport& report);

}  // namespace enamel::server
