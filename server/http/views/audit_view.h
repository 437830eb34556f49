#pragma once

#include <boost/json/object.hpp>

#include "server/storage/audit/audit_rows.h"

namespace enamel::server::http {

// A row of the audit trail, for admins and in the export of a person (schema AuditEntry). Before
// and after are the texts that the trail has, as they were written.
boost::json::object AuditJson(const AuditRow& row);

}  // namespace enamel::server::http
