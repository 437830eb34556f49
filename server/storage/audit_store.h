#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/storage/actor.h"
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
};

// The audit trail.
// A part of Store (store.h), which says what holds for all parts.
class AuditStore {
 public:
  virtual ~AuditStore() = default;

  // Newest first.
  virtual Result<std::vector<AuditRow>> Audit(uint32_t limit) = 0;
  virtual Result<std::vector<AuditRow>> FindAudit(const AuditFilter& filter) = 0;
  // What the person did and what was done to the person and the person's attempts, oldest first.
  virtual Result<std::vector<AuditRow>> AuditAbout(const Uuid& person) = 0;
  // Something that changed nothing here but is to be known: a backup, an export.
  virtual Status NoteAudit(const Actor& by, const std::string& action, const std::string& object,
                           const std::string& after_json) = 0;
};

}  // namespace enamel::server
