#include "server/http/caller.h"

#include "server/http/error_response.h"

namespace enamel::server::http {

Actor ActorOf(const Call& call) { return {call.caller->person.id, "page"}; }

Status RequireConfirmed(const Call& call) {
  if (call.authenticator.IsConfirmed(*call.caller)) return {};
  return {Code::kForbidden, "enter your password again to make this change",
          std::string(kConfirmPassword)};
}

}  // namespace enamel::server::http
