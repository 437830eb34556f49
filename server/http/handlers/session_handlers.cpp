#include <algorithm>

#include "common/base/hex.h"
#include "server/auth/device_name.h"
#include "server/http/caller.h"
#include "server/http/error_response.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"
#include "server/http/site.h"
#include "server/http/views/person_view.h"
#include "server/training/access.h"

namespace enamel::server::http {
namespace json = boost::json;
namespace {

constexpr size_t kMaxLogin = 64;
// Hashing takes as long for any length; this bounds the memory of waiting passwords.
constexpr size_t kMaxPassword = 1024;
constexpr size_t kMaxLanguage = 16;

json::object SessionJson(const auth::Identity& identity) {
  const Person& person = identity.person;
  return {{"person",
           {{"id", person.id.Text()},
            {"login", person.login},
            {"display_name", person.display_name},
            {"role", RoleName(person.role)}}},
          {"csrf", identity.csrf},
          {"must_change_password", person.must_change_password},
          {"pin_locked", person.pin_locked},
          {"may_import_teeth", CanImportTeeth(person)},
          {"language", person.language},
          {"confirmed_until_ms", identity.confirmed_until_ms}};
}

Result<Response> SignedInResponse(const auth::SignedIn& signed_in, const Request& request) {
  Response response = JsonResponse(SessionJson(signed_in.identity));
  response.headers.emplace_back("Set-Cookie",
                                SetSessionCookie(ToHex(signed_in.token), request.tls));
  response.headers.emplace_back("Set-Cookie",
                                SetDeviceCookie(signed_in.device_tokens, request.tls));
  return response;
}

}  // namespace

boost::asio::awaitable<Result<Response>> SignIn(Call call, Store&) {
  if (!IsJson(call.request)) co_return NotJson();
  Result<json::object> body =
      TextMembers(call.request, {{"login", kMaxLogin}, {"password", kMaxPassword}});
  if (!body.ok()) co_return body.status();
  auth::SignInRequest request;
  request.login = std::string((*body)["login"].as_string());
  request.password = std::string((*body)["password"].as_string());
  request.address = call.request.peer;
  request.via = auth::kViaPage;
  request.device = auth::DeviceName(call.request.Header("user-agent"));
  // Signing in ends it, and with it a session that somebody else planted in this browser.
  request.earlier = SessionCookie(call.request).value_or("");
  request.log_id = call.request.id;
  request.device_tokens = DeviceCookie(call.request);
  Result<auth::SignedIn> signed_in = co_await call.authenticator.SignIn(std::move(request));
  if (!signed_in.ok()) co_return signed_in.status();
  co_return SignedInResponse(*signed_in, call.request);
}

boost::asio::awaitable<Result<Response>> ConfirmSession(Call call, Store&) {
  if (!IsJson(call.request)) co_return NotJson();
  Result<json::object> body = TextMembers(call.request, {{"password", kMaxPassword}});
  if (!body.ok()) co_return body.status();
  std::string password((*body)["password"].as_string());
  Status confirmed =
      co_await call.authenticator.Confirm(*call.caller, std::move(password), call.request.peer);
  if (!confirmed.ok()) co_return confirmed;
  co_return Done();
}

boost::asio::awaitable<Result<Response>> ChangePassword(Call call, Store&) {
  if (!IsJson(call.request)) co_return NotJson();
  Result<json::object> body =
      TextMembers(call.request, {{"old_password", kMaxPassword}, {"new_password", kMaxPassword}});
  if (!body.ok()) co_return body.status();
  auth::Authenticator::PasswordChange change;
  change.old_password = std::string((*body)["old_password"].as_string());
  change.new_password = std::string((*body)["new_password"].as_string());
  change.address = call.request.peer;
  change.via = auth::kViaPage;
  change.device = auth::DeviceName(call.request.Header("user-agent"));
  change.device_tokens = DeviceCookie(call.request);
  Result<auth::SignedIn> signed_in =
      co_await call.authenticator.ChangePassword(*call.caller, std::move(change));
  if (!signed_in.ok()) co_return signed_in.status();
  co_return SignedInResponse(*signed_in, call.request);
}

boost::asio::awaitable<Result<Response>> SetPin(Call call, Store&) {
  if (!IsJson(call.request)) co_return NotJson();
  if (Status confirmed = RequireConfirmed(call); !confirmed.ok()) {
    co_return confirmed;
  }
  Result<json::object> body = TextMembers(call.request, {{"pin", kMaxPassword}});
  if (!body.ok()) co_return body.status();
  std::string pin((*body)["pin"].as_string());
  Status set = co_await call.authenticator.SetPin(*call.caller, std::move(pin), call.request.peer);
  if (!set.ok()) co_return set;
  co_return Done();
}

Result<Response> SetLanguage(const Call& call, Store& store) {
  if (!IsJson(call.request)) return NotJson();
  BodyReader body(call.request);
  std::string language = body.Text("language", 0, kMaxLanguage);
  ENAMEL_RETURN_IF_ERROR(body.Finish());
  if (!language.empty() && std::ranges::find(kPageLanguages, language) == kPageLanguages.end()) {
    return Status(
        Code::kInvalidInput,
        "expected language as en, de, zh, or empty for the browser's, found \"" + language + "\"",
        "language");
  }
  if (Status set = store.people.SetLanguage(call.caller->person.id, language); !set.ok()) {
    return set;
  }
  auth::Identity identity = *call.caller;
  identity.person.language = language;
  return JsonResponse(SessionJson(identity));
}

Result<Response> GetSession(const Call& call, Store&) {
  return JsonResponse(SessionJson(*call.caller));
}

Result<Response> SignOut(const Call& call, Store&) {
  if (Status ended = call.authenticator.SignOutFrom(*call.caller, call.request.peer); !ended.ok()) {
    return ended;
  }
  Response response = Done();
  // The session is over on the server already; this tidies up the browser.
  response.headers.emplace_back("Set-Cookie", SetSessionCookie("", call.request.tls));
  // Recordings too: the next person at this computer is another one.
  response.headers.emplace_back("Clear-Site-Data", "\"cache\"");
  return response;
}

Result<Response> ListSessions(const Call& call, Store& store) {
  return SessionsResponse(call, store.sessions, call.caller->person.id);
}

Result<Response> EndSession(const Call& call, Store& store) {
  Result<SessionRow> session = store.sessions.SessionById(call.id);
  bool own = session.ok() && session->person == call.caller->person.id;
  if (!session.ok() && session.status().code() != Code::kNotFound) {
    return session.status();
  }
  // Somebody else's session and none at all get the same answer.
  if (!session.ok() || (!own && call.caller->person.role != Role::kAdmin)) {
    return Status(Code::kNotFound, "there is no such session", "id");
  }
  ENAMEL_RETURN_IF_ERROR(store.sessions.EndSessionById(call.id, ActorOf(call)));
  return Done();
}

}  // namespace enamel::server::http
