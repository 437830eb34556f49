#include "server/http/wire/http_server.h"

#include <spdlog/spdlog.h>

#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <exception>
#include <string_view>
#include <utility>

#include "server/http/api.h"
#include "server/http/server_context.h"
#include "server/http/wire/connection.h"
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
            [its](tcp::socket socket, size_t) { TurnAway(*its, socket); }),
        looks(asio::make_strand(io)),
        next_look(looks) {}

  static void TurnAway(ServerContext& context, tcp::socket& socket);
  void AddFigures();
  asio::awaitable<void> WatchCertificate();

  const std::shared_ptr<ServerContext> context;
  Listener listener;
  // Looking at the certificate's files.
  Strand looks;
  asio::steady_timer next_look;
  bool stopping = false;
};

void HttpServer::State::TurnAway(ServerContext& context, tcp::socket& socket) {
  boost::system::error_code ignored;
  // One write without waiting: a refused connection must cost less than an accepted one.
  socket.non_blocking(true, ignored);
  socket.write_some(asio::buffer(kTooManyConnections), ignored);
  context.NoteRefusal(PeerAddress(socket), "503 as many connections are open as there may be");
}

void HttpServer::State::AddFigures() {
  if (context->options.metrics == nullptr) return;
  // Weakly: the metrics outlive this server, and ask it while it exists.
  context->options.metrics->Add([weak = weak_from_this()](ops::MetricsText& text) {
    auto self = weak.lock();
    if (!self) return;
    text.Gauge("enamel_http_connections", "Open page and API connections.",
               static_cast<double>(self->listener.open()));
    if (self->context->tls) {
      ops::AddCertificate(text, "page", self->context->tls->until_ms());
    }
    self->context->api->AddFigures(text);
  });
}

asio::awaitable<void> HttpServer::State::WatchCertificate() {
  while (!stopping) {
    next_look.expires_after(context->options.certificates);
    boost::system::error_code ignored;
    co_await next_look.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    if (!stopping) context->tls->Look();
  }
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
  if (state_->context->tls) {
    asio::co_spawn(state_->looks, state_->WatchCertificate(),
                   [state = state_](std::exception_ptr failed) {
                     if (failed)
                       spdlog::error("page: looking at the certificate ended by an exception");
                   });
  }
  return port;
}

void HttpServer::StationsListenAt(uint16_t port) { state_->context->api->StationsListenAt(port); }

void HttpServer::Drain() { state_->context->api->Drain(); }

void HttpServer::Stop() {
  state_->listener.Stop();
  asio::post(state_->looks, [state = state_] {
    state->stopping = true;
    state->next_look.cancel();
  });
}

}  // namespace enamel::server::http
