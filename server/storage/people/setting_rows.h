#pragma once

#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/protocol/station_policy.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// What stations are set to from here (schemas/station_settings.md, "Policy").
class SettingRows {
 public:
  explicit SettingRows(Transactions& rows) : rows_(rows) {}

  // By name, then scope.
  Result<std::vector<StationSetting>> Settings();
  // For a station: of each setting, the one of the narrowest scope.
  Result<protocol::Policy> PolicyFor(const std::string& station);
  // In place of the one of that name and scope. Errors: kInvalidInput (name, value or scope).
  Status PutSetting(const StationSetting& setting, const Actor& by);
  // Errors: kNotFound.
  Status RemoveSetting(const std::string& name, const std::string& scope, const Actor& by);

 private:
  Transactions& rows_;
};

}  // namespace enamel::server
