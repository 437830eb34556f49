#pragma once

#include "common/base/result.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/folder/space_guard.h"

namespace enamel::server {

// Whether the server takes recordings now. Thread safety: any thread.
class RecordingGate {
 public:
  RecordingGate(const Transactions& rows, SpaceGuard& space) : rows_(rows), space_(space) {}

  // Errors: kUnavailable, so that a station keeps its recordings and comes back.
  Status Check();

 private:
  const Transactions& rows_;
  SpaceGuard& space_;
};

}  // namespace enamel::server
