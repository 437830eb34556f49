#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/query.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

struct CohortSize {
  uint32_t students = 0;
  std::vector<std::string> instructors{};  // by name
};

// Cohorts and their members.
class CohortRows {
 public:
  explicit CohortRows(Transactions& rows) : rows_(rows) {}

  Result<Uuid> CreateCohort(const std::string& name, const Actor& by);
  Result<Cohort> CohortById(const Uuid& id);
  // Errors: kConflict with field kStale, without one (the name is taken).
  Result<Cohort> EditCohort(const Uuid& id, const CohortEdit& edit, int32_t revision,
                            const Actor& by);
  // All or nothing; existing members may be added and others removed without effect. Errors:
  // kNotFound with the unknown id.
  Status ChangeMembers(const Uuid& cohort, const std::vector<Uuid>& add,
                       const std::vector<Uuid>& remove, const Actor& by);
  Status AddToCohort(const Uuid& cohort, const Uuid& person, const Actor& by);
  Result<std::vector<Cohort>> CohortsOf(const Uuid& person);  // as student or instructor
  Result<std::vector<Cohort>> Cohorts();
  Result<std::vector<Person>> CohortMembers(const Uuid& cohort);
  // In the order asked for. Reads who teaches once, and counts students without reading them.
  Result<std::vector<CohortSize>> SizesOf(const std::vector<Uuid>& cohorts);

 private:
  Transactions& rows_;
};

// Inside a transaction, for other rows.
inline constexpr char kCohortColumns[] = "c.id, c.name, c.archived_ms, c.revision";
// Each leaves its audit row.
Result<Uuid> InsertCohort(Db& db, const std::string& name, const Actor& by);
Status InsertMember(Db& db, const Uuid& cohort, const Uuid& person, const Actor& by);
// Removing somebody who is no member leaves no audit row: nothing was done.
Status DeleteMember(Db& db, const Uuid& cohort, const Uuid& person, const Actor& by);

}  // namespace enamel::server
