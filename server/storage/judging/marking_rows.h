#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/transactions.h"
#include "server/training/marking.h"

namespace enamel::server {

// Blind marking.
class MarkingRows {
 public:
  explicit MarkingRows(Transactions& rows) : rows_(rows) {}

  // Of the attempts of an assignment: scored, none released. Errors: kNotFound, kConflict (a
  // marking of the assignment is under way; an attempt is released).
  Result<MarkingRow> BeginMarking(const Uuid& assignment, const std::vector<Uuid>& attempts,
                                  const std::vector<Uuid>& markers, const Actor& by);
  Result<std::vector<MarkingRow>> MarkingsOf(const Uuid& assignment);  // newest first
  Result<MarkingRow> MarkingById(const Uuid& id);
  Result<std::vector<MarkingWork>> WorksOf(const Uuid& marking);  // by id
  Result<MarkingWork> WorkById(const Uuid& work);
  // Once by each marker. Errors: kNotFound (no such work, or not this marker's), kConflict (marked
  // before, the marking is given up).
  Status AddMark(const BlindMark& mark, const Actor& by);
  Result<std::vector<BlindMark>> MarksOf(const Uuid& marking);  // by work and marker
  // The criteria of this marker's newest marks (BlindMark::criteria), at most 500, newest first.
  Result<std::vector<std::string>> CriteriaBy(const Uuid& marker);
  // Who marks from now on. The marks of those who are left out stay, and enter no result. Errors:
  // kConflict (done, given up, or somebody was left out before and may have seen scores since).
  Result<MarkingRow> SetMarkers(const Uuid& id, const std::vector<Uuid>& markers, const Actor& by);
  // Gives up what is under way; its marks stay. Errors: kConflict (done, or given up before).
  Status EndMarking(const Uuid& id, const Actor& by);
  // What a marker may not see of the attempts of markings under way.
  enum class Hidden { kScore, kAll };  // kAll: until this marker's own marks are complete
  Result<std::map<Uuid, Hidden>> HiddenFrom(const Uuid& person);

 private:
  Transactions& rows_;
};

// Inside a transaction. Errors: kConflict (a blind marking of the attempt is under way).
Status MustNotBeMarkedNow(Db& db, const Uuid& attempt);

}  // namespace enamel::server
