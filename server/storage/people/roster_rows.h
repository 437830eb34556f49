#pragma once

#include <vector>

#include "common/base/result.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/transactions.h"
#include "server/training/roster.h"

namespace enamel::server {

// People of a roster (schemas/roster.md).
class RosterRows {
 public:
  explicit RosterRows(Transactions& rows) : rows_(rows) {}

  struct Import {
    bool dry_run = false;
    bool move = false;  // students leave RosterStep::others
  };
  // Carries out what PlanRoster says, all or nothing, and returns it; with `dry_run`, or with
  // problems in the plan, changes nothing.
  Result<RosterPlan> ImportRoster(const std::vector<RosterRow>& rows, Import how, const Actor& by);

 private:
  Transactions& rows_;
};

}  // namespace enamel::server
