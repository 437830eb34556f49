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

// On the thread of its connection: it answers as long as this process turns over.
boost::asio::awaitable<Response> GetAlive(Call) { co_return JsonResponse({{"status", "ok"}}); }

// Away from the store's threads: it has to answer when they all wait for the database.
boost::asio::awaitable<Response> GetReady(Call call, Store& store) {
  StoreHealth health = co_await call.apart->Run([&store] { return store.health.Health(); });
  const bool well = health.clock_problem.empty() && health.waiting.empty();
  const char* status = call.draining              ? "draining"
                       : !health.takes_recordings ? "no_recordings"
                       : health.clock_is_off      ? "clock_off"
                       : !well                    ? "degraded"
                                                  : "ok";
  // 404: HAProxy sends no more, and leaves what runs (disable-on-404).
  const int answer = call.draining                                     ? 404
                     : !health.takes_recordings || health.clock_is_off ? 503
                                                                       : 200;
  const std::string& problem = health.problem.empty() ? health.clock_problem : health.problem;
  co_return JsonResponse({{"status", status}, {"problem", problem}, {"waiting", health.waiting}},
                         answer);
}

boost::asio::awaitable<Response> GetMetrics(Call call) {
  if (call.monitoring->metrics == nullptr || !MaySeeMetrics(call)) {
    // Not 403: strangers need not know that the figures exist.
    co_return ErrorResponse(Status{Code::kNotFound, "you are not allowed to see this"});
  }
  Response response;
  response.content_type = kPrometheusText;
  response.body =
      co_await call.apart->Run([metrics = call.monitoring->metrics] { return metrics->Text(); });
  co_return response;
}

}  // namespace enamel::server::http
