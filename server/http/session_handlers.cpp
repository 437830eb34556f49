#include "common/base/hex.h"
#include "server/http/error_response.h"
#include "server/http/handlers.h"
#include "server/http/json_body.h"
#include "server/http/site.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr size_t kMaxLogin = 64;
constexpr size_t kMaxPassword = 1024;

json::object SessionJson(const auth::Identity& identity) {
  const Person& person = identity.person;
  return {{"person",
           {{"id", person.id.Text()},
            {"login", person.login},
            {"display_name", person.display_name},
            {"role", RoleName(person.role)}}},
          {"csrf", identity.csrf}};
}

}  // namespace

boost::asio::awaitable<Response> SignIn(Call call) {
  if (!IsJson(call.request)) co_return NotJson();
  Result<json::object> body =
      TextMembers(call.request, {{"login", kMaxLogin}, {"password", kMaxPassword}});
  if (!body.ok()) co_return ErrorResponse(body.status());
  auth::SignInRequest request;
  request.login = std::string((*body)["login"].as_string());
  request.password = std::string((*body)["password"].as_string());
  request.address = call.request.peer;
  request.via = "page";
  Result<auth::SignedIn> signed_in = co_await call.authenticator.SignIn(std::move(request));
  if (!signed_in.ok()) co_return ErrorResponse(signed_in.status());
  Response response = JsonResponse(SessionJson(signed_in->identity));
  response.headers.emplace_back("Set-Cookie",
                                SetSessionCookie(ToHex(signed_in->token), call.request.tls));
  co_return response;
}

Response GetSession(const Call& call) { return JsonResponse(SessionJson(*call.caller)); }

Response SignOut(const Call& call) {
  if (Status ended = call.authenticator.SignOut(call.caller->token_hash); !ended.ok()) {
    return ErrorResponse(ended);
  }
  Response response;
  response.status = 204;
  response.headers.emplace_back("Set-Cookie", SetSessionCookie("", call.request.tls));
  return response;
}

}  // namespace enamel::server::http
