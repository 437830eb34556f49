#include "server/http/views/person_view.h"

#include <boost/json.hpp>

#include "server/http/error_response.h"
#include "server/http/json_body.h"
#include "server/http/paging.h"

namespace enamel::server::http {
namespace json = boost::json;

json::object PersonJson(const Person& person) {
  return {{"id", person.id.Text()},
          {"login", person.login},
          {"display_name", person.display_name},
          {"role", RoleName(person.role)},
          {"disabled", person.disabled},
          {"must_change_password", person.must_change_password},
          {"may_import_teeth", person.may_import_teeth},
          {"created_ms", person.created_ms},
          {"revision", person.revision}};
}

Result<Response> SessionsResponse(const Call& call, SessionRows& sessions_rows,
                                  const Uuid& person) {
  ENAMEL_ASSIGN_OR_RETURN(Page page, PageOf(call.request, 50, 200));
  ENAMEL_ASSIGN_OR_RETURN(std::vector<SessionRow> rows, sessions_rows.SessionsOf(person));
  json::value next = CutPage(rows, page, [](const SessionRow& row) { return row.id.Text(); });
  json::array sessions;
  for (const SessionRow& row : rows) {
    sessions.push_back({{"id", row.id.Text()},
                        {"via", row.via},
                        {"address", row.address},
                        {"device", row.device},
                        {"created_ms", row.created_ms},
                        {"last_used_ms", row.last_used_ms},
                        {"expires_ms", row.expires_ms},
                        // So that nobody ends the session they sit in by mistake. The hash itself
                        // stays here.
                        {"current", row.token_hash == call.caller->token_hash}});
  }
  return JsonResponse({{"sessions", std::move(sessions)}, {"next", std::move(next)}});
}

}  // namespace enamel::server::http
