#include "server/http/views/audit_view.h"

#include <boost/json.hpp>

namespace enamel::server::http {

boost::json::object AuditJson(const AuditRow& row) {
  return {{"at_ms", row.at_ms},   {"actor", row.actor},        {"action", row.action},
          {"object", row.object}, {"before", row.before_json}, {"after", row.after_json}};
}

}  // namespace enamel::server::http
