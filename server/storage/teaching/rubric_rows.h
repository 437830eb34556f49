#pragma once

#include <optional>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// Corrections of a published exercise's rubric. The exercise's document, and with it every
// recording that names it, is unchanged; scores name the rubric's version.
class RubricRows {
 public:
  RubricRows(Transactions& rows, Blobs& blobs) : rows_(rows), blobs_(blobs) {}

  // What counts now. None: the rubric in the exercise's document.
  Result<std::optional<RubricRow>> RubricFor(const Uuid& exercise);
  Result<std::vector<RubricRow>> Rubrics(const Uuid& exercise);  // newest first
  // Uses exercise, version, content (a stored blob) and reason of `row`. Existing scores stay until
  // a rescore. Errors: kNotFound (exercise, blob), kConflict with field kStale (version is not one
  // more than the newest correction's: somebody else was first), without one (a draft, which is
  // edited instead; the newest correction is identical).
  Result<RubricRow> PublishRubric(const RubricRow& row, const Actor& by);

 private:
  Transactions& rows_;
  Blobs& blobs_;
};

}  // namespace enamel::server
