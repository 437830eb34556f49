#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/actor.h"
#include "server/training/types.h"

namespace enamel::server {

// The cuts that attempts are compared with.
// A part of Store (store.h), which says what holds for all parts.
class ReferenceStore {
 public:
  virtual ~ReferenceStore() = default;

  // A sealed and scored attempt becomes the exercise's reference (newest that is not withdrawn
  // wins); attempts of that exercise which were sealed without a reference are queued for scoring,
  // itself included (it then reads deviation 0). `consent`: students may see the name. Marked again,
  // it counts once, under its new name. `anyway`: why it is one although a check speaks against it
  // (jobs/reference_check.h); it goes to the audit trail. Errors also: kConflict, field "score", of
  // one that scored 0.
  virtual Result<ReferenceRow> AddReference(const Uuid& attempt, const std::string& dentist,
                                            bool consent, const Actor& by,
                                            const std::string& anyway = {}) = 0;
  virtual Result<ReferenceRow> ReferenceById(const Uuid& id) = 0;
  // Newest first, withdrawn ones too.
  virtual Result<std::vector<ReferenceRow>> References(const Uuid& exercise) = 0;
  // Scores made with it stay until they are made again.
  virtual Status WithdrawReference(const Uuid& id, const Actor& by) = 0;
  virtual Result<std::optional<ReferenceRow>> ReferenceFor(const Uuid& exercise) = 0;
};

}  // namespace enamel::server
