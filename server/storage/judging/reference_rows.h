#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// The cuts that attempts are compared with.
class ReferenceRows {
 public:
  explicit ReferenceRows(Transactions& rows) : rows_(rows) {}

  // A sealed and scored attempt becomes a reference of the exercise. It is queued for scoring (it
  // then reads deviation 0). So are attempts that the exercise's own target has judged, where this
  // is the only reference that counts. `consent`: students may see the name. Marked again, it counts once, under its new name.
  // `anyway`: why it is one although a check speaks against it (jobs/reference_check.h); it goes to
  // the audit trail. Errors also: kConflict, field "score", of one that scored 0.
  Result<ReferenceRow> AddReference(const Uuid& attempt, const std::string& dentist, bool consent,
                                    const Actor& by, const std::string& anyway = {});
  Result<ReferenceRow> ReferenceById(const Uuid& id);
  // Newest first, withdrawn ones too.
  Result<std::vector<ReferenceRow>> References(const Uuid& exercise);
  // Those that judge: not withdrawn, newest first, at most kMaxCounting.
  static constexpr size_t kMaxCounting = 8;
  Result<std::vector<ReferenceRow>> Counting(const Uuid& exercise);
  // Scores made with it stay until a rescore.
  Status WithdrawReference(const Uuid& id, const Actor& by);
  // The newest of them, which an exercise shows and makes a target from.
  Result<std::optional<ReferenceRow>> ReferenceFor(const Uuid& exercise);
  // Those for which ReferenceFor finds one, in one question.
  Result<std::set<Uuid>> ExercisesWithReference();

 private:
  Transactions& rows_;
};

}  // namespace enamel::server
