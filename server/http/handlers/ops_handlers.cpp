#include "server/auth/token.h"
#include "server/http/error_response.h"
#include "server/http/handlers/handlers.h"
#include "server/http/json_body.h"

// For those who run the server.
namespace enamel::server::http {
namespace {

constexpr const char* kPrometheusText = "text/plain; version=0.0.4; charset=utf-8";

bool IsThisMachine(std::string_view peer) {
  return peer == "::1" || peer.starts_with("127.") || peer.starts_with("::ffff:127.");
}

bool MaySeeMetrics(const Call& call) {
  const std::string& token = call.monitoring->token;
  // Behind a proxy the peer is the browser's address, so that the proxy's own does not open the
  // door.
  if (token.empty()) return IsThisMachine(call.request.peer);
  return auth::SameSecret(call.request.Header("authorization"), "Bearer " + token);
}

}  // namespace

// Away from the store's threads: it has to answer when they all wait for the database.
boost::asio::awaitable<Response> GetHealth(Call call, Store& store) {
  StoreHealth health = co_await call.apart->Run([&store] { return store.health.Health(); });
  const char* status = call.draining                   ? "draining"
                       : !health.takes_recordings      ? "no_recordings"
                       : !health.clock_problem.empty() ? "clock_off"
                                                       : "ok";
  const std::string& problem = health.problem.empty() ? health.clock_problem : health.problem;
  co_return JsonResponse({{"status", status}, {"problem", problem}, {"waiting", health.waiting}},
                         status == std::string_view("ok") ? 200 : 503);
}

Response GetMetrics(const Call& call) {
  if (call.monitoring->metrics == nullptr || !MaySeeMetrics(call)) {
    // Not 403: strangers need not know that the figures exist.
    return ErrorResponse(Status{Code::kNotFound, "you are not allowed to see this"});
  }
  Response response;
  response.content_type = kPrometheusText;
  response.body = call.monitoring->metrics->Text();
  return response;
}

}  // namespace enamel::server::http
