#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// The devices that graded work is done with (HandsAllowed::kListed).
class DeviceRows {
 public:
  explicit DeviceRows(Transactions& rows) : rows_(rows) {}

  // By name. HandsAllowed::kListed admits these. Of the swings only those of the school's newest thousand attempts.
  Result<std::vector<ListedDevice>> ListedDevices();
  // A listed device gets the new title. Errors: kInvalidInput (name or title).
  Status ListDevice(const std::string& name, const std::string& title, const Actor& by);
  // Errors: kNotFound.
  Status UnlistDevice(const std::string& name, const Actor& by);
  Result<bool> IsListed(const Hand& hand);

 private:
  Transactions& rows_;
};

// Inside a transaction, for other rows.
Result<bool> IsListedIn(Db& db, const Hand& hand);

}  // namespace enamel::server
