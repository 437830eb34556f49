#pragma once

#include <cstdint>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// Remarks about a moment of an attempt.
class RemarkRows {
 public:
  explicit RemarkRows(Transactions& rows) : rows_(rows) {}

  // One to the chair gets a remark_id and waits for its station (LiveRows::ChairRemarks).
  Result<AnnotationRow> AddAnnotation(const AnnotationRow& row, const Actor& by);
  // Text, tick and point of `row` count; `revision` as for drafts (exercise_rows.h).
  Result<AnnotationRow> ReplaceAnnotation(const AnnotationRow& row, const Actor& by);
  Status DeleteAnnotation(const Uuid& id, int32_t revision, const Actor& by);
  Result<AnnotationRow> AnnotationById(const Uuid& id);
  // By tick.
  Result<std::vector<AnnotationRow>> AnnotationsOf(const Uuid& attempt);

 private:
  Transactions& rows_;
};

}  // namespace enamel::server
