#include "server/http/http_server.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/url/parse.hpp>
#include <boost/url/url_view.hpp>
#include <functional>
#include <list>
#include <mutex>
#include <string_view>

#include "server/http/api.h"
#include "server/http/error_response.h"
#include "server/http/message.h"
#include "server/http/request_head.h"
#include "server/http/site.h"
#include "server/http/static_files.h"

namespace enamel::server::http {
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace bhttp = boost::beast::http;
using asio::ip::tcp;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;

namespace {

constexpr auto kNoThrow = asio::as_tuple(asio::use_awaitable);
constexpr size_t kReadBytes = 4096;
constexpr size_t kMaxDrainBytes = 4 * kMaxBodyBytes;
constexpr std::chrono::milliseconds kDrain{1000};
constexpr std::chrono::milliseconds kAcceptPause{100};
// How often a viewer is shown what is new, and how long nothing may be sent. The system keeps
// little for a viewer who does not read.
constexpr std::chrono::milliseconds kEventPeriod{100};
constexpr std::chrono::seconds kEventSilence{15};
constexpr int kEventSendBuffer = 64 * 1024;
constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
constexpr std::string_view kTooManyConnections =
    "HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\nRetry-After: 5\r\n"
    "Connection: close\r\n\r\n";

std::string_view View(const beast::flat_buffer& buffer) {
  return {static_cast<const char*>(buffer.data().data()), buffer.size()};
}

}  // namespace

// What Stop needs of a connection. Touched on the connection's strand only.
struct Connection {
  asio::any_io_executor strand;
  std::function<void()> close;  // empty once the stream is gone
  bool idle = true;             // between requests
  bool stopping = false;

  void Close() {
    if (close) close();
  }
};

struct HttpServer::State : std::enable_shared_from_this<State> {
  State(asio::io_context& context, HttpOptions given, Store& store, auth::Authenticator& auth)
      : io(context),
        options(std::move(given)),
        api(std::make_unique<Api>(store, auth, Monitoring{options.metrics, options.metrics_token},
                                  options.store_threads, options.max_in_flight)),
        strand(asio::make_strand(context)),
        acceptor(strand),
        stop_timer(strand) {
    if (options.live) api->Show(*options.live);
  }

  Status Prepare();
  void AddFigures();
  Status Listen(const asio::ip::address& address);
  asio::awaitable<void> Accept();
  void Spawn(tcp::socket socket);
  void Forget(std::list<std::shared_ptr<Connection>>::iterator place);
  asio::awaitable<void> StopAll();
  void ForEachConnection(const std::function<void(Connection&)>& visit);

  template <typename Stream>
  asio::awaitable<void> ServeAll(Stream& stream, const std::string& peer, Connection& connection);
  asio::awaitable<void> ServePlain(beast::tcp_stream stream, std::string peer,
                                   std::shared_ptr<Connection> connection);
  asio::awaitable<void> ServeTls(TlsStream stream, std::string peer,
                                 std::shared_ptr<Connection> connection);
  asio::awaitable<Response> Answer(const Request& request);

  // Constant after Start.
  asio::io_context& io;
  HttpOptions options;
  std::optional<asio::ssl::context> tls;
  std::optional<StaticFiles> files;

  std::unique_ptr<Api> api;  // until the server is destroyed

  // On `strand`.
  asio::strand<asio::io_context::executor_type> strand;
  tcp::acceptor acceptor;
  asio::steady_timer stop_timer;
  bool stopping = false;

  std::mutex mutex;
  std::list<std::shared_ptr<Connection>> connections;  // guarded by mutex
};

namespace {

Request PlainRequest(const bhttp::request<bhttp::string_body>& message, std::string peer,
                     bool tls) {
  Request out;
  switch (message.method()) {
    case bhttp::verb::get:
      out.method = Method::kGet;
      break;
    case bhttp::verb::head:
      out.method = Method::kHead;
      break;
    case bhttp::verb::post:
      out.method = Method::kPost;
      break;
    case bhttp::verb::delete_:
      out.method = Method::kDelete;
      break;
    case bhttp::verb::patch:
      out.method = Method::kPatch;
      break;
    default:
      out.method = Method::kOther;
      break;
  }
  for (const auto& field : message) {
    std::string name(field.name_string());
    std::transform(name.begin(), name.end(), name.begin(), [](char c) {
      return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    std::string& value = out.headers[name];
    if (!value.empty()) value += name == "cookie" ? "; " : ", ";
    value += std::string_view(field.value().data(), field.value().size());
  }
  out.body = message.body();
  out.peer = std::move(peer);
  out.tls = tls;
  return out;
}

// Path and decoded query. Errors: kInvalidInput.
Status TakeTarget(std::string_view target, Request& request) {
  auto url = boost::urls::parse_origin_form({target.data(), target.size()});
  if (url.has_error()) {
    return {Code::kInvalidInput, "expected a percent-encoded path and query", "request line"};
  }
  auto path = url->encoded_path();
  request.path.assign(path.data(), path.size());
  for (const auto& param : url->params()) request.query[param.key] = param.value;
  return {};
}

// Reads until a whole head is in the buffer. False: the peer went away, or the deadline passed.
// Errors: kTooLarge.
template <typename Stream>
asio::awaitable<Result<bool>> ReadHead(Stream& stream, beast::flat_buffer& buffer,
                                       const HttpDeadlines& deadlines, Connection& connection,
                                       size_t& head_end) {
  head_end = FindHeadEnd(View(buffer));
  connection.idle = buffer.size() == 0;
  beast::get_lowest_layer(stream).expires_after(connection.idle ? deadlines.idle : deadlines.head);
  while (head_end == std::string_view::npos) {
    size_t before = buffer.size();
    if (before >= kMaxHeadBytes) {
      co_return Status{Code::kTooLarge, "expected a request line and headers of at most 16 KiB"};
    }
    auto [error, count] = co_await stream.async_read_some(
        buffer.prepare(std::min(kReadBytes, kMaxHeadBytes - before)), kNoThrow);
    if (error) co_return false;
    buffer.commit(count);
    if (connection.idle) {
      connection.idle = false;
      beast::get_lowest_layer(stream).expires_after(deadlines.head);
    }
    head_end = FindHeadEnd(View(buffer), before);
  }
  co_return true;
}

template <typename Stream>
asio::awaitable<bool> Write(Stream& stream, Response& response, bool head_only, bool keep_alive,
                            const HttpOptions& options) {
  AddSecurityHeaders(response, options.tls.has_value());
  bhttp::response<bhttp::span_body<const char>> message;
  message.version(11);
  message.result(static_cast<unsigned>(response.status));
  for (const auto& [name, value] : response.headers) message.insert(name, value);
  if (!response.content_type.empty()) {
    message.set(bhttp::field::content_type, response.content_type);
  }
  message.keep_alive(keep_alive);
  std::string_view body = response.Body();
  if (response.status != 204 && response.status != 304) message.content_length(body.size());
  if (!head_only) message.body() = {body.data(), body.size()};
  bhttp::response_serializer<bhttp::span_body<const char>> serializer(message);
  beast::get_lowest_layer(stream).expires_after(options.deadlines.write);
  auto [error, count] = co_await bhttp::async_write(stream, serializer, kNoThrow);
  co_return !error;
}

// Empty when there is nothing to send yet.
std::string TextOf(const EventSource::Event& event, bool silent_for_long) {
  std::string text;
  if (event.data) text = "event: ticks\ndata: " + *event.data + "\n\n";
  if (event.last) text += "event: end\ndata: {}\n\n";
  return text.empty() && silent_for_long ? ":\n\n" : text;
}

template <typename Stream>
asio::awaitable<bool> WriteEventsHead(Stream& stream, Response& response,
                                      const HttpOptions& options) {
  AddSecurityHeaders(response, options.tls.has_value());
  bhttp::response<bhttp::empty_body> message;
  message.version(11);
  message.result(static_cast<unsigned>(response.status));
  for (const auto& [name, value] : response.headers) message.insert(name, value);
  message.set(bhttp::field::content_type, response.content_type);
  message.keep_alive(false);
  bhttp::response_serializer<bhttp::empty_body> serializer(message);
  beast::get_lowest_layer(stream).expires_after(options.deadlines.write);
  auto [error, count] = co_await bhttp::async_write_header(stream, serializer, kNoThrow);
  co_return !error;
}

// The newest event whenever there is a new one, until either side has had enough.
template <typename Stream>
asio::awaitable<void> WriteEvents(Stream& stream, Response response, const HttpOptions& options,
                                  Connection& connection) {
  using Clock = std::chrono::steady_clock;
  beast::tcp_stream& lowest = beast::get_lowest_layer(stream);
  beast::error_code ignored;
  lowest.socket().set_option(asio::socket_base::send_buffer_size(kEventSendBuffer), ignored);
  bool open = co_await WriteEventsHead(stream, response, options);
  connection.idle = true;  // stopping does not wait for it
  asio::steady_timer pause(connection.strand);
  auto end = Clock::now() + options.deadlines.events;
  auto last_sent = Clock::now();
  while (open && !connection.stopping && Clock::now() < end) {
    EventSource::Event event = response.events->Take();
    std::string text = TextOf(event, Clock::now() - last_sent > kEventSilence);
    if (!text.empty()) {
      last_sent = Clock::now();
      lowest.expires_after(options.deadlines.event);
      auto [error, count] = co_await asio::async_write(stream, asio::buffer(text), kNoThrow);
      open = !error && !event.last;
    }
    pause.expires_after(kEventPeriod);
    co_await pause.async_wait(kNoThrow);
  }
}

// Ends the sending side and reads what the peer still sends for a while, so that the answer is not
// lost to a reset.
template <typename Stream>
asio::awaitable<void> Drain(Stream& stream, beast::flat_buffer& buffer) {
  beast::tcp_stream& lowest = beast::get_lowest_layer(stream);
  beast::error_code ignored;
  lowest.socket().shutdown(tcp::socket::shutdown_send, ignored);
  lowest.expires_after(kDrain);
  buffer.clear();
  for (size_t drained = 0; drained < kMaxDrainBytes;) {
    auto [error, count] = co_await lowest.async_read_some(buffer.prepare(kReadBytes), kNoThrow);
    if (error) break;
    drained += count;
  }
}

// What came of waiting for a request.
struct Incoming {
  enum class Kind { kClosed, kRefused, kRequest } kind = Kind::kClosed;
  Request request;
  bool keep_alive = false;
  Response refusal;
};

Incoming Refused(Response refusal) {
  Incoming out;
  out.kind = Incoming::Kind::kRefused;
  out.refusal = std::move(refusal);
  return out;
}

// An error of reading head or body: an answer where the peer is still there to get it.
Incoming FailedRead(const beast::error_code& error) {
  if (error == bhttp::error::body_limit) {
    return Refused(ErrorResponse({Code::kTooLarge, "expected a body of at most 1 MiB"}));
  }
  bool malformed = error.category() == make_error_code(bhttp::error::bad_version).category() &&
                   error != bhttp::error::partial_message && error != bhttp::error::end_of_stream;
  if (!malformed) return {};
  return Refused(
      ErrorResponse({Code::kInvalidInput, "expected an HTTP/1.1 request: " + error.message()}));
}

Incoming TakeMessage(const bhttp::request<bhttp::string_body>& message, const std::string& peer,
                     bool tls) {
  Incoming out;
  out.request = PlainRequest(message, peer, tls);
  out.keep_alive = message.keep_alive();
  auto target = message.target();
  Status valid = TakeTarget({target.data(), target.size()}, out.request);
  if (!valid.ok()) return Refused(ErrorResponse(valid));
  out.kind = Incoming::Kind::kRequest;
  return out;
}

template <typename Stream>
asio::awaitable<Incoming> ReadMessage(Stream& stream, beast::flat_buffer& buffer,
                                      const std::string& peer, const HttpOptions& options) {
  bhttp::request_parser<bhttp::string_body> parser;
  parser.header_limit(kMaxHeadBytes);
  parser.body_limit(kMaxBodyBytes);
  beast::get_lowest_layer(stream).expires_after(options.deadlines.body);
  auto [head_error, head_bytes] =
      co_await bhttp::async_read_header(stream, buffer, parser, kNoThrow);
  if (head_error) co_return FailedRead(head_error);
  if (beast::iequals(parser.get()[bhttp::field::expect], "100-continue")) {
    auto [write_error, written] =
        co_await asio::async_write(stream, asio::buffer(kContinue), kNoThrow);
    if (write_error) co_return Incoming{};
  }
  auto [body_error, body_bytes] = co_await bhttp::async_read(stream, buffer, parser, kNoThrow);
  if (body_error) co_return FailedRead(body_error);
  co_return TakeMessage(parser.get(), peer, options.tls.has_value());
}

template <typename Stream>
asio::awaitable<Incoming> ReadRequest(Stream& stream, beast::flat_buffer& buffer,
                                      const std::string& peer, const HttpOptions& options,
                                      Connection& connection) {
  size_t head_end = 0;
  Result<bool> complete =
      co_await ReadHead(stream, buffer, options.deadlines, connection, head_end);
  if (!complete.ok()) {
    co_return Refused(ErrorResponse(431, "too_large", complete.status().message()));
  }
  if (!*complete) co_return Incoming{};
  Status head = CheckRequestHead(View(buffer).substr(0, head_end));
  if (!head.ok()) co_return Refused(ErrorResponse(head));
  co_return co_await ReadMessage(stream, buffer, peer, options);
}

// One request and its answer. False: close the connection.
template <typename Stream, typename Answer>
asio::awaitable<bool> ServeOne(Stream& stream, beast::flat_buffer& buffer, const std::string& peer,
                               const HttpOptions& options, Connection& connection,
                               const Answer& answer) {
  Incoming incoming = co_await ReadRequest(stream, buffer, peer, options, connection);
  if (incoming.kind == Incoming::Kind::kClosed) co_return false;
  Response response = std::move(incoming.refusal);
  bool keep_alive = false;
  if (incoming.kind == Incoming::Kind::kRequest) {
    response = co_await answer(incoming.request);
    keep_alive = incoming.keep_alive && !connection.stopping;
  }
  bool head_only = incoming.request.method == Method::kHead;
  if (response.events && !head_only) {
    co_await WriteEvents(stream, std::move(response), options, connection);
    co_return false;
  }
  bool written = co_await Write(stream, response, head_only, keep_alive, options);
  if (written && !keep_alive) co_await Drain(stream, buffer);
  co_return written&& keep_alive;
}

std::string PeerAddress(const tcp::socket& socket) {
  beast::error_code error;
  auto endpoint = socket.remote_endpoint(error);
  return error ? std::string() : endpoint.address().to_string();
}

Status LoadTls(asio::ssl::context& context, const TlsFiles& files) {
  beast::error_code error;
  SSL_CTX_set_min_proto_version(context.native_handle(), TLS1_3_VERSION);
  context.use_certificate_chain_file(files.certificate_chain.string(), error);
  if (error) {
    return {Code::kNotFound, "expected a PEM certificate chain in " +
                                 files.certificate_chain.string() + ": " + error.message()};
  }
  context.use_private_key_file(files.private_key.string(), asio::ssl::context::pem, error);
  if (error) {
    return {Code::kNotFound, "expected the certificate's PEM key in " + files.private_key.string() +
                                 ": " + error.message()};
  }
  return {};
}

}  // namespace

asio::awaitable<Response> HttpServer::State::Answer(const Request& request) {
  if (!HostAllowed(request.Header("host"), options.host_names)) {
    co_return ErrorResponse(421, "misdirected",
                            "expected a host name of this server, found " +
                                std::string(request.Header("host")) +
                                "; open the page under its own address",
                            "host");
  }
  if (Api::Owns(request.path)) co_return co_await api->Handle(request);
  if (files) co_return files->Serve(request);
  co_return ErrorResponse(Status{Code::kNotFound, "this server was started without the page"});
}

template <typename Stream>
asio::awaitable<void> HttpServer::State::ServeAll(Stream& stream, const std::string& peer,
                                                  Connection& connection) {
  beast::flat_buffer buffer(kMaxHeadBytes + kReadBytes);
  auto answer = [this](const Request& request) { return Answer(request); };
  bool open = true;
  while (open && !connection.stopping) {
    open = co_await ServeOne(stream, buffer, peer, options, connection, answer);
  }
}

asio::awaitable<void> HttpServer::State::ServePlain(beast::tcp_stream stream, std::string peer,
                                                    std::shared_ptr<Connection> connection) {
  connection->close = [&stream] { stream.close(); };
  co_await ServeAll(stream, peer, *connection);
  connection->close = nullptr;
}

asio::awaitable<void> HttpServer::State::ServeTls(TlsStream stream, std::string peer,
                                                  std::shared_ptr<Connection> connection) {
  connection->close = [&stream] { beast::get_lowest_layer(stream).close(); };
  beast::get_lowest_layer(stream).expires_after(options.deadlines.handshake);
  auto [error] = co_await stream.async_handshake(asio::ssl::stream_base::server, kNoThrow);
  if (!error) co_await ServeAll(stream, peer, *connection);
  connection->close = nullptr;
}

void HttpServer::State::Spawn(tcp::socket socket) {
  auto connection = std::make_shared<Connection>();
  connection->strand = socket.get_executor();
  std::list<std::shared_ptr<Connection>>::iterator place;
  {
    std::lock_guard lock(mutex);
    if (connections.size() >= options.max_connections) {
      beast::error_code ignored;
      socket.non_blocking(true, ignored);
      socket.write_some(asio::buffer(kTooManyConnections), ignored);
      return;
    }
    place = connections.insert(connections.end(), connection);
  }
  std::string peer = PeerAddress(socket);
  auto strand_of = connection->strand;
  beast::tcp_stream plain(std::move(socket));
  auto serve = tls ? ServeTls(TlsStream(std::move(plain), *tls), std::move(peer), connection)
                   : ServePlain(std::move(plain), std::move(peer), connection);
  asio::co_spawn(strand_of, std::move(serve),
                 [self = shared_from_this(), place](const std::exception_ptr& failed) {
                   if (failed) spdlog::error("http: a connection ended with an exception");
                   self->Forget(place);
                 });
}

asio::awaitable<void> HttpServer::State::Accept() {
  auto self = shared_from_this();
  while (acceptor.is_open()) {
    auto [error, socket] = co_await acceptor.async_accept(asio::make_strand(io), kNoThrow);
    if (!error) {
      beast::error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      Spawn(tcp::socket(std::move(socket)));
    } else if (acceptor.is_open()) {  // out of descriptors, most likely: let some be closed
      asio::steady_timer pause(strand, kAcceptPause);
      co_await pause.async_wait(kNoThrow);
    }
  }
}

Status HttpServer::State::Prepare() {
  beast::error_code error;
  asio::ip::address address = asio::ip::make_address(options.address, error);
  if (error) {
    return {Code::kInvalidInput,
            "expected a numeric address such as 127.0.0.1, found '" + options.address + "'",
            "address"};
  }
  if (!address.is_loopback() && !options.tls) {
    return {Code::kInvalidInput,
            "expected TLS for " + options.address +
                ": passwords do not travel in the clear; give a certificate and key, or listen on "
                "127.0.0.1",
            "address"};
  }
  if (options.host_names.empty() && !address.is_loopback()) {
    return {Code::kInvalidInput, "expected the host names the page is opened under", "host_names"};
  }
  if (options.host_names.empty()) options.host_names = {"127.0.0.1", "localhost", "[::1]"};
  if (options.tls) {
    tls.emplace(asio::ssl::context::tls_server);
    ENAMEL_RETURN_IF_ERROR(LoadTls(*tls, *options.tls));
  }
  if (!options.web_root.empty()) {
    Result<StaticFiles> loaded = StaticFiles::Load(options.web_root);
    if (!loaded.ok()) return loaded.status();
    files = std::move(*loaded);
  }
  return Listen(address);
}

void HttpServer::State::AddFigures() {
  if (options.metrics == nullptr) return;
  options.metrics->Add([weak = weak_from_this()](ops::MetricsText& text) {
    auto self = weak.lock();
    if (!self || !self->api) return;
    {
      std::lock_guard lock(self->mutex);
      text.Gauge("enamel_http_connections", "Open page and API connections.",
                 static_cast<double>(self->connections.size()));
    }
    constexpr std::string_view kKinds[] = {"1xx", "2xx", "3xx", "4xx", "5xx"};
    for (size_t i = 1; i <= std::size(kKinds); ++i) {
      text.Counter("enamel_http_answers_total", "API answers by kind of status.",
                   static_cast<double>(self->api->answers()[i].load()),
                   {{"status", kKinds[i - 1]}});
    }
    text.Durations("enamel_http_read_seconds", "API reads, from the whole request to the answer.",
                   self->api->reads().counts());
  });
}

Status HttpServer::State::Listen(const asio::ip::address& address) {
  tcp::endpoint endpoint(address, options.port);
  beast::error_code error;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (!error) return {};
  const std::string where = options.address + ":" + std::to_string(options.port);
  if (error == asio::error::address_in_use) {
    return {Code::kUnavailable,
            "expected a free port, found " + where +
                " in use; stop the program that holds it or choose another port",
            "port"};
  }
  return {Code::kUnavailable, "expected to listen on " + where + ", found: " + error.message(),
          "address"};
}

void HttpServer::State::ForEachConnection(const std::function<void(Connection&)>& visit) {
  std::lock_guard lock(mutex);
  for (const auto& connection : connections) {
    asio::post(connection->strand, [connection, visit] { visit(*connection); });
  }
}

void HttpServer::State::Forget(std::list<std::shared_ptr<Connection>>::iterator place) {
  std::lock_guard lock(mutex);
  connections.erase(place);
  if (connections.empty()) {
    asio::post(strand, [self = shared_from_this()] { self->stop_timer.cancel(); });
  }
}

asio::awaitable<void> HttpServer::State::StopAll() {
  auto self = shared_from_this();
  if (stopping) co_return;
  stopping = true;
  beast::error_code ignored;
  acceptor.close(ignored);
  ForEachConnection([](Connection& connection) {
    connection.stopping = true;
    if (connection.idle) connection.Close();
  });
  {
    std::lock_guard lock(mutex);
    if (connections.empty()) co_return;
  }
  stop_timer.expires_after(options.deadlines.stop);
  co_await stop_timer.async_wait(kNoThrow);
  ForEachConnection([](Connection& connection) { connection.Close(); });
}

HttpServer::HttpServer(asio::io_context& io, HttpOptions options, Store& store,
                       auth::Authenticator& authenticator)
    : state_(std::make_shared<State>(io, std::move(options), store, authenticator)) {}

// Waits for the store's threads: nothing of ours touches the store afterwards.
HttpServer::~HttpServer() { state_->api.reset(); }

Result<uint16_t> HttpServer::Start() {
  if (Status ready = state_->Prepare(); !ready.ok()) return ready;
  state_->AddFigures();
  uint16_t port = state_->acceptor.local_endpoint().port();
  asio::co_spawn(state_->strand, state_->Accept(), asio::detached);
  return port;
}

void HttpServer::Stop() {
  asio::co_spawn(
      state_->strand, [state = state_] { return state->StopAll(); }, asio::detached);
}

}  // namespace enamel::server::http
