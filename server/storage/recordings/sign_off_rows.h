#pragma once

#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// Who signed exam attempts at their stations (schemas/wire/README.md, "Sign-off"). Whether the
// signer may, and gave the right PIN, is for the caller to have checked.
class SignOffRows {
 public:
  explicit SignOffRows(Transactions& rows) : rows_(rows) {}

  // Signs the start while its ticket is valid and the attempt not opened, the end before it is
  // sealed. The same signer
  // again: nothing changes. Errors: kNotFound; kConflict (no sign-off is required, too early, too
  // late, somebody else has signed).
  Status Sign(const Uuid& attempt, SignedAt at, UnixMs now_ms, const Actor& by);
  // Start before end; those that are there.
  Result<std::vector<SignOffRow>> SignOffsOf(const Uuid& attempt);

 private:
  Transactions& rows_;
};

// Inside a transaction. Errors: kForbidden with field "sign_off".
Status StartMustBeSigned(Db& db, const Uuid& attempt);

}  // namespace enamel::server
