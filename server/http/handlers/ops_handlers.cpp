#include <boost/json.hpp>
#include <optional>
#include <utility>

#include "server/auth/token.h"
#include "server/http/error_response.h"
#include "server/http/json_body.h"
#include "server/http/operations.h"

// For those who run the server.
namespace enamel::server::http {
namespace json = boost::json;
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

std::pair<const char*, int> StatusOf(Readiness ready, bool draining) {
  // 404: HAProxy sends no more, and leaves what runs (disable-on-404).
  if (draining) return {"draining", 404};
  switch (ready) {
    case Readiness::kReady:
      break;
    case Readiness::kDegraded:
      return {"degraded", 200};
    case Readiness::kClockOff:
      return {"clock_off", 503};
    case Readiness::kNoRecordings:
      return {"no_recordings", 503};
  }
  return {"ok", 200};
}

}  // namespace

// On the thread of its connection: it answers as long as this process turns over.
boost::asio::awaitable<Result<Response>> GetAlive(Call, Store&) {
  co_return JsonResponse({{"status", "ok"}});
}

// Away from the store's threads: it has to answer when they all wait for the database.
boost::asio::awaitable<Result<Response>> GetReady(Call call, Store& store) {
  StoreHealth health = co_await call.apart->Run([&store] { return store.health.Health(); });
  const auto& ask = call.monitoring->peers;
  const std::optional<PeersView> peers = ask ? ask() : PeersView{};
  const Readiness ready = ReadinessOf(health, peers);
  const auto [status, answer] = StatusOf(ready, call.draining);
  const std::string& problem = health.problem.empty() ? health.clock_problem : health.problem;
  json::object out{{"status", status}, {"problem", problem}, {"waiting", health.waiting}};
  if (peers && peers->asked > 0) {
    out["peers"] = {{"asked", peers->asked},
                    {"answered", peers->answered},
                    {"database", peers->database},
                    {"blobs", peers->blobs},
                    {"keys", peers->keys}};
  }
  co_return JsonResponse(out, answer);
}

boost::asio::awaitable<Result<Response>> GetHealth(Call call, Store& store) {
  return GetReady(call, store);
}

boost::asio::awaitable<Result<Response>> GetMetrics(Call call, Store&) {
  if (call.monitoring->metrics == nullptr || !MaySeeMetrics(call)) {
    // Not 403: strangers need not know that the figures exist.
    co_return Status(Code::kNotFound, "you are not allowed to see this");
  }
  Response response;
  response.content_type = kPrometheusText;
  response.body =
      co_await call.apart->Run([metrics = call.monitoring->metrics] { return metrics->Text(); });
  co_return response;
}

}  // namespace enamel::server::http
