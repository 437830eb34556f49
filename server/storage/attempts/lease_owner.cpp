#include "server/storage/attempts/lease_owner.h"

#include "server/storage/engine/query.h"

namespace enamel::server {
namespace {

// The process that held them has ended: waiting for the leases to run out would only delay the
// scores.
Status EndLeases(Db& db, const Uuid& owner) {
  Query q(db,
          "UPDATE jobs SET lease_until_ms = 0 WHERE tenant = ?1 AND state = 'running' AND (owner = "
          "?2 OR owner IS NULL)");
  ENAMEL_RETURN_IF_ERROR(q.Bind(owner).Run());
  Query timelines(db,
                  "UPDATE timelines SET lease_until_ms = 0 WHERE tenant = ?1 AND owner = ?2 AND "
                  "content IS NULL");
  return timelines.Bind(owner).Run();
}

}  // namespace

Status LeaseOwner::EndEarlier() {
  MutexLock lock(mutex_);
  if (!earlier_) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(rows_.WriteRow([&](Db& db) { return EndLeases(db, id_); }));
  earlier_ = false;
  return Status::Ok();
}

}  // namespace enamel::server
