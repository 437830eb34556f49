#pragma once

#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/attempts/lease_owner.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// The present state that all servers of a school share: remarks on their way to chairs, and which
// stations are connected to which server.
class LiveRows {
 public:
  LiveRows(Transactions& rows, const LeaseOwner& owner) : rows_(rows), owner_(owner) {}

  // Remarks to the chairs of attempts in progress since then, oldest first
  // (RemarkRows::AddAnnotation).
  Result<std::vector<ChairRemark>> ChairRemarks(UnixMs since_ms);
  // Stores how far these have come. Never moves one back; a deleted one stays deleted.
  Status MoveRemarks(const std::vector<ChairRemark>& moved);
  // A server that has not called KeepLinks for so long has none.
  static constexpr UnixMs kServerSilentMs = 20'000;
  // Stations of this server: those that connected or changed `shows_remarks`, and those that left.
  // Call it even without changes, as a sign of life. Errors: kNotFound (this server was silent for
  // so long that others deleted its rows, and nothing of this call is kept: send everything again
  // with `anew`).
  Status KeepLinks(const std::vector<StationLink>& come, const std::vector<Uuid>& gone, bool anew);
  // Those of the other servers. A station may be connected to two for a while.
  Result<std::vector<StationLink>> LinksElsewhere();
  // That were heard within kServerSilentMs, besides this one.
  Result<size_t> OtherServers();

 private:
  Transactions& rows_;
  const LeaseOwner& owner_;
};

}  // namespace enamel::server
