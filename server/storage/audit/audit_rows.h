#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "server/storage/audit/actor.h"
#include "server/storage/engine/transactions.h"
#include "server/training/types.h"

namespace enamel::server {

struct AuditFilter {
  std::optional<Uuid> actor{};
  std::string action{};  // whole ("person.edit") or, with a dot at the end, a kind ("person.")
  std::string object{};  // whole
  UnixMs from_ms = 0;
  UnixMs until_ms = 0;           // 0: now
  std::optional<Uuid> before{};  // page: older than this row
  uint32_t limit = 100;          // at most 1000
};

struct AuditRow {
  UnixMs at_ms = 0;
  std::string actor;
  std::string action;  // "attempt.seal", "person.create"
  std::string object;
  std::string before_json, after_json;
  Uuid id{};
  std::string via{};  // how the actor came: "page", "station bench-2"
};

// The audit trail, to read it and to note in it.
class AuditRows {
 public:
  explicit AuditRows(Transactions& rows) : rows_(rows) {}

  // Newest first.
  Result<std::vector<AuditRow>> Audit(uint32_t limit);
  Result<std::vector<AuditRow>> FindAudit(const AuditFilter& filter);
  // The newest of an action; none: it was never noted.
  Result<std::optional<AuditRow>> NewestOf(const std::string& action);
  // Actions by the person, and on the person and the person's attempts, oldest first.
  Result<std::vector<AuditRow>> AuditAbout(const Uuid& person);
  // Something that changed nothing here but is to be known: a backup, an export.
  Status NoteAudit(const Actor& by, const std::string& action, const std::string& object,
                   const std::string& after_json);

 private:
  Transactions& rows_;
};

}  // namespace enamel::server
