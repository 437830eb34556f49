#pragma once

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/engine/transactions.h"

namespace enamel::server {

// Under which name this process holds jobs and timelines. Thread safety: any thread.
class LeaseOwner {
 public:
  // `server`: this is the server, and what an earlier process of it held is over. Else what runs
  // beside the server, under a name of its own, so that it is not taken for the server.
  LeaseOwner(Transactions& rows, const Uuid& id, bool server)
      : rows_(rows), id_(id), earlier_(server) {}

  const Uuid& id() const { return id_; }
  // Before the first lease: others may have at once what an earlier process of this server held.
  Status EndEarlier();

 private:
  Transactions& rows_;
  const Uuid id_;
  Mutex mutex_;
  bool earlier_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::server
