#include "server/http/wire/http_server.h"

#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
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
            [its](tcp::socket socket, size_t) { TurnAway(*its, socket); }) {}

  static void TurnAway(ServerContext& context, tcp::socket& socket);
  void AddFigures();

  const std::shared_ptr<ServerContext> context;
  Listener listener;
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
    self->context->api->AddFigures(text);
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
