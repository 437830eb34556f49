#pragma once

#include <boost/json/object.hpp>

#include "server/storage/audit_store.h"

namespace enamel::server::http {

// A row of the audit trail, for admins and in the export of a person (schema AuditEntry). What was
// there before and after is the text it was written as: what was recorded is shown, also what an
// older version wrote in another shape.
boost::json::object AuditJson(const AuditRow& row);

}  // namespace enamel::server::http
