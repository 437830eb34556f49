#pragma once

#include <vector>

#include "common/base/result.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// Texts that those who teach say again and again in remarks. They go with their owner.
class SavedTextRows {
 public:
  // Of one person: as many as somebody still looks through. Of all that are shared, because
  // everybody who teaches is shown them.
  static constexpr int64_t kMaxOwn = 100;
  static constexpr int64_t kMaxShared = 300;

  explicit SavedTextRows(Transactions& rows) : rows_(rows) {}

  // Those of this person, and those that others share; newest first.
  Result<std::vector<SavedText>> SavedTexts(const Uuid& person);
  Result<SavedText> SavedTextById(const Uuid& id);
  // Text and sharing of `row` count; the actor owns it. Errors: kConflict with field "text" (the
  // actor has it already, or as many as allowed) or "shared" (as many as allowed are).
  Result<SavedText> AddSavedText(const SavedText& row, const Actor& by);
  // Those of `row` count; `revision` as for drafts (exercise_rows.h). Errors: as before.
  Result<SavedText> ReplaceSavedText(const SavedText& row, const Actor& by);
  Status DeleteSavedText(const Uuid& id, int32_t revision, const Actor& by);

 private:
  Transactions& rows_;
};

}  // namespace enamel::server
