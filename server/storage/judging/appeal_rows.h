#pragma once

#include <optional>
#include <string>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// Appeals of students against a score.
class AppealRows {
 public:
  explicit AppealRows(Transactions& rows) : rows_(rows) {}

  // One per attempt (kConflict), of a released one.
  Status FileAppeal(const Uuid& attempt, const std::string& text, const Actor& by);
  // With `regrade` as Rescore, in the same transaction. Errors: kNotFound, kConflict (answered).
  Status AnswerAppeal(const Uuid& attempt, bool regrade, const std::string& answer,
                      const Actor& by);
  Result<std::optional<AppealRow>> AppealOf(const Uuid& attempt);

 private:
  Transactions& rows_;
};

}  // namespace enamel::server
