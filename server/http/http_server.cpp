#include "server/http/http_server.h"

#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <string_view>
#include <utility>

#include "server/http/api.h"
#include "server/http/connection.h"
#include "server/http/server_context.h"
#include "server/net/listener.h"

namespace enamel::server::http {

namespace asio = boost::asio;
using asio::ip::tcp;

namespace {

// In the clear also where TLS is spoken: a handshake would cost more than was saved by refusing. A
// browser then sees a connection that ends.
constexpr std::string_view kTooManyConnections =
    "HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\nRetry-After: 5\r\n"
    "Connection: close\r\n\r\n";

}  // namespace

struct HttpServer::State : std::enable_shared_from_this<State> {
  State(asio::io_context& io, const std::shared_ptr<ServerContext>& its)
      : context(its),
        listener(
            io,
            {"page", its->options.address, its->options.port, its->options.max_connections,
             its->options.deadlines.stop},
            [its](tcp::socket socket, Strand strand, const std::string& peer) {
              return MakeConnection(std::move(socket), peer, std::move(strand), its);
            },
            [its](tcp::socket socket, size_t) { TurnAway(*its, socket); }) {}

  static void TurnAway(ServerContext& context, tcp::socket& socket);
  void AddFigures();

  const std::shared_ptr<ServerContext> context;
  Listener listener;
};

void HttpServer::State::TurnAway(ServerContext& context, tcp::socket& socket) {
  boost::system::error_code ignored;
  // One write and no waiting for it: what is turned away must cost less than what is let in.
  socket.non_blocking(true, ignored);
  socket.write_some(asio::buffer(kTooManyConnections), ignored);
  context.NoteRefusal(PeerAddress(socket), "503 as many connections are open as there may be");
}

void HttpServer::State::AddFigures() {
  if (context->options.metrics == nullptr) return;
  // Weakly: the figures live longer than this server, and ask it as long as it is there.
  context->options.metrics->Add([weak = weak_from_this()](ops::MetricsText& text) {
    auto self = weak.lock();
    if (!self) return;
    const Api& api = *self->context->api;
    text.Gauge("enamel_http_connections", "Open page and API connections.",
               static_cast<double>(self->listener.open()));
    constexpr std::string_view kKinds[] = {"1xx", "2xx", "3xx", "4xx", "5xx"};
    for (size_t i = 1; i <= std::size(kKinds); ++i) {
      text.Counter("enamel_http_answers_total", "API answers by kind of status.",
                   static_cast<double>(api.answers()[i].load()), {{"status", kKinds[i - 1]}});
    }
    const auth::DoorCounts& door = api.door();
    const std::pair<std::string_view, const std::atomic<uint64_t>*> kOutcomes[] = {
        {"signed_in", &door.signed_in},
        {"refused", &door.refused},
        {"throttled", &door.throttled},
        {"busy", &door.busy}};
    for (const auto& [outcome, count] : kOutcomes) {
      text.Counter("enamel_sign_ins_total",
                   "Sign-ins at page and stations, and passwords asked for again, by outcome.",
                   static_cast<double>(count->load()), {{"outcome", outcome}});
    }
    text.Counter("enamel_sign_outs_total", "Sign-outs at the page.",
                 static_cast<double>(door.signed_out.load()));
    text.Counter("enamel_http_forbidden_total", "API requests without the right to them.",
                 static_cast<double>(api.forbidden()));
    text.Durations("enamel_http_read_seconds", "API reads, from the whole request to the answer.",
                   api.reads().counts());
  });
}

HttpServer::HttpServer(asio::io_context& io, HttpOptions options, Store& store,
                       auth::Authenticator& authenticator)
    : state_(std::make_shared<State>(
          io, std::make_shared<ServerContext>(std::move(options), store, authenticator))) {}

// Waits for the store's threads: nothing of ours touches the store afterwards.
HttpServer::~HttpServer() { state_->context->api->EndWork(); }

Result<uint16_t> HttpServer::Start() {
  ENAMEL_RETURN_IF_ERROR(state_->context->Prepare());
  ENAMEL_ASSIGN_OR_RETURN(auto port, state_->listener.Start());
  state_->AddFigures();
  return port;
}

void HttpServer::StationsListenAt(uint16_t port) { state_->context->api->StationsListenAt(port); }

void HttpServer::Drain() { state_->context->api->Drain(); }

void HttpServer::Stop() { state_->listener.Stop(); }

}  // namespace enamel::server::http
