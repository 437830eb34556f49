#pragma once

#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/attempts/lease_owner.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// What goes on now and has to be known at all servers of a school: remarks on their way to chairs,
// and which stations are connected where.
class LiveRows {
 public:
  LiveRows(Transactions& rows, const LeaseOwner& owner) : rows_(rows), owner_(owner) {}

  // Of the attempts that are being made: what was said at their chairs since then, oldest first
  // (RemarkRows::AddAnnotation).
  Result<std::vector<ChairRemark>> ChairRemarks(UnixMs since_ms);
  // How far these have come. What is further already stays so; one that was deleted stays deleted.
  Status MoveRemarks(const std::vector<ChairRemark>& moved);
  // A server that has not called KeepLinks for so long has none.
  static constexpr UnixMs kServerSilentMs = 20'000;
  // Of this server: these have come, or their `shows_remarks` is another now, and these are gone.
  // Also with nothing new, to be heard. Errors: kNotFound (it was silent for so long that others
  // deleted what it had said, and nothing is kept of this call: say all of it again with `anew`).
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
