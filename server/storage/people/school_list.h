#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

// A school that an installation's servers serve beside the installation's own. All its data is in a
// store of its own (server/app/school_folder.h): with PostgreSQL in a schema of its own, so that no
// statement of one school can name a row of another. kBeingMade, kBeingDeleted: the command runs or
// was interrupted; the same command finishes.
enum class SchoolState : uint8_t { kBeingMade, kServed, kSuspended, kBeingDeleted };
const char* SchoolStateName(SchoolState state);  // "being_made", …

struct SchoolRow {
  std::string name;                // IsSchoolName
  Uuid id;                         // a new one each time a school is made, also under an old name
  std::vector<std::string> hosts;  // IsHostName; the first is the one that people are told
  // Only kServed lets anybody in. Suspended: nothing is done, all is kept.
  SchoolState state = SchoolState::kServed;
  UnixMs created_ms = 0;
};

// 1 to 32 of a-z 0-9 -, a letter first.
bool IsSchoolName(std::string_view name);
// A DNS name in lower case, without port and without a dot at its end: at most 253 bytes, labels of
// 1 to 63 of a-z 0-9 -, no hyphen first or last.
bool IsHostName(std::string_view host);

// The schools of an installation, in the store of the installation's own. Only the command line
// changes them: an admin of that school is no admin of the others.
class SchoolRows {
 public:
  explicit SchoolRows(Transactions& rows) : rows_(rows) {}

  // By name.
  Result<std::vector<SchoolRow>> Schools();
  // Errors: kInvalidInput (name, hosts), kConflict (the name is taken, or a host is another
  // school's).
  Status AddSchool(const SchoolRow& row, const Actor& by);
  // Its hosts and its state. One that is being made is served next or deleted, one that is served
  // is suspended before it is deleted, and one that is being deleted stays so. Errors: those of
  // AddSchool, kNotFound, kConflict (of these steps).
  Status ChangeSchool(const SchoolRow& row, const Actor& by);
  // Forgets it; its data must be deleted already. Errors: kNotFound, kConflict (it is not being
  // deleted).
  Status RemoveSchool(const std::string& name, const Actor& by);

 private:
  Transactions& rows_;
};

}  // namespace enamel::server
