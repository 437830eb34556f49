#include "server/http/http_server.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <functional>
#include <list>
#include <mutex>
#include <string_view>

#include "server/auth/address_block.h"
#include "server/http/api.h"
#include "server/http/error_response.h"
#include "server/http/message.h"
#include "server/http/request_reader.h"
#include "server/http/site.h"
#include "server/http/static_files.h"
#include "server/net/connection_limit.h"
#include "server/ops/refusal_log.h"

namespace enamel::server::http {
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace bhttp = boost::beast::http;
using asio::ip::tcp;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;

namespace {

constexpr auto kNoThrow = asio::as_tuple(asio::use_awaitable);
auto Into(beast::error_code& error) { return asio::redirect_error(asio::use_awaitable, error); }
constexpr size_t kReadBytes = 4096;
constexpr size_t kMaxDrainBytes = 4 * kMaxBodyBytes;
constexpr std::chrono::milliseconds kDrain{1000};
constexpr std::chrono::milliseconds kAcceptPause{100};
constexpr size_t kMaxLeaving = 64;  // connections that make room and are not closed yet
// How often a viewer is shown what is new (all viewers at the same moments), and how long nothing
// may be sent. The system keeps little for a viewer who does not read.
constexpr std::chrono::milliseconds kEventPeriod{100};
constexpr std::chrono::seconds kEventSilence{15};
constexpr int kEventSendBuffer = 64 * 1024;
constexpr std::string_view kHealthPath = "/healthz";  // also for the proxy itself
constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
constexpr std::string_view kTooManyConnections =
    "HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\nRetry-After: 5\r\n"
    "Connection: close\r\n\r\n";

std::string_view View(const beast::flat_buffer& buffer) {
  return {static_cast<const char*>(buffer.data().data()), buffer.size()};
}

// The reason begins with the status, which alone tells refusals apart: what follows may be what the
// peer wrote.
void Note(ops::RefusalLog& refusals, const std::string& peer, const std::string& reason) {
  refusals.Note({"a peer at " + peer, reason.substr(0, reason.find(' ')), reason});
}

// The browser's end of the line is TLS, here or at the proxy.
bool IsSecure(const HttpOptions& options) {
  return options.tls.has_value() || !options.trusted_proxies.empty();
}

}  // namespace

// What Stop needs of a connection. Touched on the connection's strand only.
struct Connection {
  asio::any_io_executor strand;
  std::function<void()> close;  // empty once the stream is gone
  bool idle = true;             // between requests
  bool stopping = false;
  // For making room, from any thread: waits for what the peer sends; sends what the peer reads.
  std::atomic<bool> receiving{true}, sending{false};
  bool leaving = false;  // was told to make room; guarded by State::mutex
  std::string block;     // auth::AddressBlock of the peer; constant

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
    api->Enrol(options.station_fingerprint);
  }

  Status Prepare();
  void AddFigures();
  Status Listen(const asio::ip::address& address);
  asio::awaitable<void> Accept();
  std::shared_ptr<Connection> WhoMayGo(std::atomic<bool> Connection::*state);
  bool HasRoom();  // or makes some; with mutex held
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
  asio::awaitable<Response> Answer(Request& request);

  // Constant after Start.
  asio::io_context& io;
  HttpOptions options;
  std::optional<asio::ssl::context> tls;
  std::optional<StaticFiles> files;

  std::unique_ptr<Api> api;  // until the server is destroyed
  ops::RefusalLog refusals{"page"};

  // On `strand`.
  asio::strand<asio::io_context::executor_type> strand;
  tcp::acceptor acceptor;
  asio::steady_timer stop_timer;
  bool stopping = false;

  std::mutex mutex;
  std::list<std::shared_ptr<Connection>> connections;  // guarded by mutex; first come first
  size_t leaving = 0;                                  // of those; guarded by mutex
};

namespace {

// Reads until `reader` has a request or refuses it. kMore: the peer went away, or a deadline passed
// (`late`).
template <typename Stream>
asio::awaitable<RequestReader::Step> ReadRequest(Stream& stream, beast::flat_buffer& buffer,
                                                 RequestReader& reader,
                                                 const HttpDeadlines& deadlines,
                                                 Connection& connection, bool& late) {
  using Step = RequestReader::Step;
  connection.idle = buffer.size() == 0;
  connection.receiving = true;
  beast::get_lowest_layer(stream).expires_after(connection.idle ? deadlines.idle : deadlines.head);
  for (;;) {
    bool in_head = reader.in_head();
    size_t used = 0;
    Step step = reader.Feed(View(buffer), used);
    buffer.consume(used);
    if (step == Step::kRequest || step == Step::kRefused) co_return step;
    if (in_head && !reader.in_head()) {
      beast::get_lowest_layer(stream).expires_after(deadlines.body);
    }
    beast::error_code error;
    if (step == Step::kContinue) {
      co_await asio::async_write(stream, asio::buffer(kContinue), Into(error));
      if (error) co_return Step::kMore;
    }
    size_t count = co_await stream.async_read_some(
        buffer.prepare(std::min(kReadBytes, buffer.max_size() - buffer.size())), Into(error));
    late = !connection.idle && error == beast::error::timeout;
    if (error) co_return Step::kMore;
    buffer.commit(count);
    if (connection.idle) {
      connection.idle = false;
      beast::get_lowest_layer(stream).expires_after(deadlines.head);
    }
  }
}

template <typename Stream>
asio::awaitable<bool> Write(Stream& stream, Response& response, bool head_only, bool keep_alive,
                            const HttpOptions& options) {
  AddCommonHeaders(response, IsSecure(options));
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
  AddCommonHeaders(response, IsSecure(options));
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

// The next moment at which viewers are shown what is new: the same for all of them, so that fifty
// viewers wake the server ten times a second and not five hundred times.
std::chrono::steady_clock::time_point NextEventMoment() {
  auto since = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::steady_clock::time_point((since / kEventPeriod + 1) * kEventPeriod);
}

// The newest event whenever there is a new one, until either side has had enough.
template <typename Stream>
asio::awaitable<void> WriteEvents(Stream& stream, Response response, const HttpOptions& options,
                                  Connection& connection, Api& api) {
  using Clock = std::chrono::steady_clock;
  beast::tcp_stream& lowest = beast::get_lowest_layer(stream);
  beast::error_code ignored;
  lowest.socket().set_option(asio::socket_base::send_buffer_size(kEventSendBuffer), ignored);
  bool open = co_await WriteEventsHead(stream, response, options);
  connection.idle = true;  // stopping does not wait for it
  asio::steady_timer pause(connection.strand);
  auto end = Clock::now() + options.deadlines.events;
  auto last_sent = Clock::now();
  auto last_allowed = Clock::now();
  while (open && !connection.stopping && Clock::now() < end) {
    EventSource::Event event = response.events->Take();
    std::string text = TextOf(event, Clock::now() - last_sent > kEventSilence);
    if (!text.empty()) {
      last_sent = Clock::now();
      lowest.expires_after(options.deadlines.event);
      auto [error, count] = co_await asio::async_write(stream, asio::buffer(text), kNoThrow);
      open = !error && !event.last;
    }
    pause.expires_at(NextEventMoment());
    co_await pause.async_wait(kNoThrow);
    if (Clock::now() - last_allowed < options.deadlines.allowed) continue;
    bool allowed = co_await api.StillAllowed(*response.events);
    if (!allowed) co_return;
    last_allowed = Clock::now();
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

// One request and its answer. False: close the connection.
template <typename Stream, typename Answer>
asio::awaitable<bool> ServeOne(Stream& stream, beast::flat_buffer& buffer, const std::string& peer,
                               const HttpOptions& options, ops::RefusalLog& refusals,
                               Connection& connection, Api& api, const Answer& answer) {
  RequestReader reader;
  bool late = false;
  RequestReader::Step step =
      co_await ReadRequest(stream, buffer, reader, options.deadlines, connection, late);
  if (late) Note(refusals, peer, "408 a request did not arrive within its time");
  connection.receiving = false;
  if (step == RequestReader::Step::kMore) co_return false;
  Response response;
  bool keep_alive = false;
  if (step == RequestReader::Step::kRequest) {
    reader.request().peer = peer;
    reader.request().tls = options.tls.has_value();
    response = co_await answer(reader.request());
    keep_alive = reader.keep_alive() && !connection.stopping;
  } else {
    response = std::move(reader.refusal());
    Note(refusals, peer, std::to_string(response.status) + " " + response.body);
  }
  bool head_only = reader.request().method == Method::kHead;
  if (response.events && !head_only) {
    co_await WriteEvents(stream, std::move(response), options, connection, api);
    co_return false;
  }
  connection.sending = true;
  bool written = co_await Write(stream, response, head_only, keep_alive, options);
  if (written && !keep_alive) co_await Drain(stream, buffer);
  connection.sending = false;
  if (!written) co_return false;
  co_return keep_alive;
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

asio::awaitable<Response> HttpServer::State::Answer(Request& request) {
  if (!options.trusted_proxies.empty() && request.path != kHealthPath) {
    const std::string peer = request.peer;
    if (Status known = TakeFromProxy(options.trusted_proxies, request); !known.ok()) {
      Note(refusals, peer, "403 " + known.message());
      co_return ErrorResponse(known);
    }
  }
  if (!HostAllowed(request.Header("host"), options.host_names)) {
    Note(refusals, request.peer, "421 the host it asked for is not one of this server's names");
    co_return ErrorResponse(421, "misdirected",
                            "expected a host name of this server, found " +
                                std::string(request.Header("host")) +
                                "; open the page under its own address",
                            "host");
  }
  if (Api::Owns(request.path)) co_return co_await api->Handle(request);
  if (files) co_return files->Serve(request);
  co_return ErrorResponse(Status{Code::kNotFound,
                                 "this server was started without the page; start it with --web "
                                 "and the folder of the built page, "
                                 "such as --web web/dist"});
}

template <typename Stream>
asio::awaitable<void> HttpServer::State::ServeAll(Stream& stream, const std::string& peer,
                                                  Connection& connection) {
  beast::flat_buffer buffer(kMaxHeadBytes + kReadBytes);
  auto answer = [this](Request& request) { return Answer(request); };
  bool open = true;
  while (open && !connection.stopping) {
    open = co_await ServeOne(stream, buffer, peer, options, refusals, connection, *api, answer);
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

// First of those who have asked for nothing yet, or nothing more; then of those who do not take
// their answer. With mutex held.
std::shared_ptr<Connection> HttpServer::State::WhoMayGo(std::atomic<bool> Connection::*state) {
  std::vector<std::shared_ptr<Connection>> all;
  std::vector<Closable> guests;
  for (const auto& connection : connections) {
    if (connection->leaving) continue;
    all.push_back(connection);
    guests.push_back({connection->block, (*connection.*state).load()});
  }
  std::optional<size_t> found = PickToClose(guests);
  return found ? all[*found] : nullptr;
}

bool HttpServer::State::HasRoom() {
  if (connections.size() - leaving < options.max_connections) return true;
  if (leaving >= kMaxLeaving) return false;
  std::shared_ptr<Connection> goes = WhoMayGo(&Connection::receiving);
  if (!goes) goes = WhoMayGo(&Connection::sending);
  if (!goes) return false;
  goes->leaving = true;
  ++leaving;
  asio::post(goes->strand, [goes] {
    goes->stopping = true;
    goes->Close();
  });
  return true;
}

void HttpServer::State::Spawn(tcp::socket socket) {
  auto connection = std::make_shared<Connection>();
  connection->strand = socket.get_executor();
  std::string peer = PeerAddress(socket);
  connection->block = auth::AddressBlock(peer);
  std::list<std::shared_ptr<Connection>>::iterator place;
  {
    std::lock_guard lock(mutex);
    if (!HasRoom()) {
      beast::error_code ignored;
      socket.non_blocking(true, ignored);
      socket.write_some(asio::buffer(kTooManyConnections), ignored);
      Note(refusals, peer, "503 as many connections are open as there may be");
      return;
    }
    place = connections.insert(connections.end(), connection);
  }
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
  if (!address.is_loopback() && !options.tls && options.trusted_proxies.empty()) {
    return {
        Code::kInvalidInput,
        "expected TLS for " + options.address +
            ": passwords do not travel in the clear; give a certificate and key, name the proxy "
            "that speaks TLS to the browsers, or listen on 127.0.0.1",
        "address"};
  }
  for (const std::string& proxy : options.trusted_proxies) {
    if (asio::ip::make_address(proxy, error).to_string() == proxy && !error) continue;
    return {Code::kInvalidInput,
            "expected a proxy's numeric address such as 10.0.0.5, found '" + proxy + "'",
            "trusted_proxies"};
  }
  bool reached_from_afar = !address.is_loopback() || !options.trusted_proxies.empty();
  if (options.host_names.empty() && reached_from_afar) {
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
    const auth::DoorCounts& door = self->api->door();
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
                 static_cast<double>(self->api->forbidden()));
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
  if ((*place)->leaving) --leaving;
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
