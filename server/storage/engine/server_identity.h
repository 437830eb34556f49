#pragma once

#include <optional>

#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/sql/db.h"
#include "server/storage/engine/transactions.h"

namespace enamel::server {

// The parts of a server's identity: for stations, in signatures, and for its key ring.
enum class ServerPart { kStationCertificate, kTicketKey, kKeyRing };

// The table `server_identity`: keeps the fingerprint unless there is one, and compares it. In a
// transaction of either isolation. Errors: those of ServerIdentityRows.
Status MatchIdentityRow(sql::Db& db, ServerPart part, const std::optional<Sha256>& fingerprint);

// What all servers of one database have in common.
class ServerIdentityRows {
 public:
  explicit ServerIdentityRows(Transactions& rows) : rows_(rows) {}

  // Where several servers have their rows in one database, all are known by the same: the first
  // one's fingerprint is kept, and another is refused. Without one: a server that has none yet asks
  // whether it may make its own. Elsewhere nothing is compared. Errors: kConflict (another),
  // kNotFound (it may not).
  Status MatchIdentity(ServerPart part, const std::optional<Sha256>& fingerprint);

 private:
  Transactions& rows_;
};

}  // namespace enamel::server
