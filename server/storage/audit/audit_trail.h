#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/result.h"
#include "common/base/uuid.h"
#include "common/sql/db.h"
#include "server/storage/audit/actor.h"
#include "server/storage/audit/audit_row.h"

// The audit trail inside a transaction (schemas/audit.md): whoever changes something adds a row
// about it in the same transaction. The connection is the writer's, which has the signer with it.
namespace enamel::server {

// Rows about the subject that is bound as ?2. Without its second half, which a parameter does not
// prove, SQLite does not use the partial index and reads the whole trail with every change.
inline constexpr char kAboutSubject[] = "tenant = ?1 AND subject = ?2 AND subject <> ''";

// {"name":value,…} of text values.
std::string JsonOf(std::initializer_list<std::pair<const char*, std::string>> members);
// Adds a signed row with the present state of the action's subject (decisions.h): call it after the
// change.
Status WriteAudit(sql::Db& db, const Actor& by, const char* action, const std::string& object,
                  const std::string& before, const std::string& after);
// The same about a subject that action and object do not tell.
Status WriteAuditAbout(sql::Db& db, const std::string& subject, const Actor& by, const char* action,
                       const std::string& object, const std::string& before,
                       const std::string& after);

// Where one chain ends, or each. None: no row is in it.
Result<std::optional<AuditHead>> FindAuditHead(sql::Db& db, const Uuid& chain);
Result<std::vector<AuditHead>> AuditHeads(sql::Db& db);

}  // namespace enamel::server
