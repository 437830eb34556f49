#include "server/net/listener.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <csignal>
#include <map>
#include <utility>
#include <vector>

#include "common/base/check.h"
#include "server/net/connection_limit.h"
#include "server/net/proxy_header.h"

namespace enamel::server {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

// Accepting fails when the process is out of descriptors, most likely: at once and for as long as
// it is. A connection that ends in this time gives one back.
constexpr std::chrono::milliseconds kAcceptPause{100};

auto Into(error_code& error) { return asio::redirect_error(asio::use_awaitable, error); }

// Reads the PROXY header, then hands the socket on. A header that is wrong or late ends the
// connection.
class Introduction : public AcceptedConnection, public std::enable_shared_from_this<Introduction> {
 public:
  using Then = std::function<void(tcp::socket socket, Strand strand, const std::string& peer)>;

  // `name`: of the listener, for the log.
  Introduction(tcp::socket socket, Strand strand, std::string proxy, std::string name,
               std::chrono::milliseconds time, Then then)
      : socket_(std::move(socket)),
        strand_(std::move(strand)),
        late_(strand_),
        proxy_(std::move(proxy)),
        name_(std::move(name)),
        time_(time),
        then_(std::move(then)) {}

  void Run(std::function<void()> on_end) override {
    asio::post(strand_,
               [self = shared_from_this(), on_end = std::move(on_end)] { self->Begin(on_end); });
  }
  // Nothing was asked yet that could be finished.
  void BeginStop() override { Close(); }
  void Close() override {
    asio::post(strand_, [self = shared_from_this()] { self->CloseSocket(); });
  }
  GivesWay gives_way() const override { return GivesWay::kFirst; }
  const std::string& block() const override { return proxy_; }

 private:
  // The header may be there already, and Read may end on another thread at once: the timer is set
  // first, on the strand that also cancels it.
  void Begin(const std::function<void()>& on_end) {
    ENAMEL_CHECK(strand_.running_in_this_thread());
    late_.expires_after(time_);
    late_.async_wait([self = weak_from_this()](error_code cancelled) {
      auto there = self.lock();
      if (there && !cancelled) there->CloseSocket();
    });
    asio::co_spawn(
        strand_, Read(),
        [self = shared_from_this(), on_end](std::exception_ptr failure, bool introduced) {
          self->late_.cancel();
          if (!failure && introduced) {
            return self->then_(std::move(self->socket_), self->strand_, self->peer_);
          }
          self->CloseSocket();
          on_end();
        });
  }
  asio::awaitable<bool> Read();
  void CloseSocket() {
    ENAMEL_CHECK(strand_.running_in_this_thread());
    error_code ignored;
    socket_.close(ignored);
  }
  bool Refuse(const Status& why) {
    spdlog::warn("{}: the proxy at {}: {}", name_, proxy_, why.message());
    return false;
  }

  tcp::socket socket_;
  const Strand strand_;
  asio::steady_timer late_;
  const std::string proxy_, name_;
  const std::chrono::milliseconds time_;
  const Then then_;
  std::string peer_;
};

asio::awaitable<bool> Introduction::Read() {
  error_code error;
  co_await socket_.async_wait(tcp::socket::wait_read, Into(error));
  uint8_t begin = 0;
  if (!error) socket_.receive(asio::buffer(&begin, 1), tcp::socket::message_peek, error);
  if (error) co_return false;
  // Somebody on the proxy's machine, such as another server: who it is stays unsaid.
  if (begin == kTlsHandshake) co_return true;
  std::array<uint8_t, kProxyStartBytes> first{};
  co_await asio::async_read(socket_, asio::buffer(first), Into(error));
  // A proxy that only sees whether somebody listens says nothing.
  if (error) co_return false;
  const auto start = ReadProxyStart(first);
  if (!start.ok()) co_return Refuse(start.status());
  std::vector<uint8_t> rest(start->rest_bytes);
  co_await asio::async_read(socket_, asio::buffer(rest), Into(error));
  if (error) co_return false;
  const auto peer = ReadProxyPeer(*start, rest);
  if (!peer.ok()) co_return Refuse(peer.status());
  peer_ = peer->empty() ? proxy_ : *peer;
  co_return true;
}

// In the spelling in which a peer's address is shown: they are compared as text.
Status CheckProxies(const std::vector<std::string>& proxies) {
  for (const std::string& proxy : proxies) {
    error_code error;
    if (asio::ip::make_address(proxy, error).to_string() == proxy && !error) continue;
    return {Code::kInvalidInput,
            "expected a proxy's numeric address such as 10.0.0.5, found '" + proxy + "'",
            "proxies"};
  }
  return {};
}

}  // namespace

// Connections are held weakly: each lives as long as its own coroutine. So destroying `io` destroys
// the connections that wait in it, and no circle keeps either.
struct Listener::State : std::enable_shared_from_this<State> {
  State(asio::io_context& context, ListenerOptions o, Make m, TurnAway t)
      : io(context),
        options(std::move(o)),
        make(std::move(m)),
        turn_away(std::move(t)),
        strand(asio::make_strand(context)),
        acceptor(strand),
        grace(strand) {}

  Status Listen();
  asio::awaitable<void> Accept();
  std::shared_ptr<AcceptedConnection> PickToGiveWay(GivesWay when, uint64_t& id);
  bool MakeRoom();
  void Admit(tcp::socket socket, Strand its);
  std::shared_ptr<AcceptedConnection> AskProxy(uint64_t id, tcp::socket socket, Strand its,
                                               const std::string& proxy);
  void Introduced(uint64_t id, tcp::socket socket, Strand its, const std::string& peer);
  std::function<void()> Ended(uint64_t id);
  void Forget(uint64_t id);
  void StopOnStrand();
  void VisitAll(const std::function<void(AcceptedConnection&)>& visit, bool made_only = false);

  asio::io_context& io;
  const ListenerOptions options;
  const Make make;
  const TurnAway turn_away;
  std::atomic<size_t> open{0};  // connections.size(), for other threads

  // Owned by the strand.
  struct Entry {
    std::weak_ptr<AcceptedConnection> connection;
    bool closing = false;  // was told to give way
    bool made = true;      // by `make`; false while a proxy is asked for whom it comes
  };
  Strand strand;
  tcp::acceptor acceptor;
  asio::steady_timer grace;               // of stopping
  std::map<uint64_t, Entry> connections;  // by age, the oldest first
  size_t closing = 0;                     // of those
  uint64_t next_id = 0;
  bool stopping = false;
};

Status Listener::State::Listen() {
  error_code error;
  auto address = asio::ip::make_address(options.address, error);
  if (error) {
    return {Code::kInvalidInput,
            "expected a numeric address such as 127.0.0.1, found '" + options.address + "'",
            "address"};
  }
  tcp::endpoint endpoint(address, options.port);
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (!error) return {};
  const std::string where = options.address + ":" + std::to_string(options.port);
  if (error == asio::error::address_in_use) {
    return {Code::kUnavailable,
            "expected a free port, found " + where +
                " in use; stop the program that holds it or name another one",
            "port"};
  }
  return {Code::kUnavailable, "expected to listen on " + where + ", found: " + error.message(),
          "address"};
}

asio::awaitable<void> Listener::State::Accept() {
  while (!stopping) {
    error_code error;
    Strand its = asio::make_strand(io);
    tcp::socket socket(its);
    co_await acceptor.async_accept(socket, Into(error));
    if (stopping) co_return;
    if (!error) {
      Admit(std::move(socket), its);
      continue;
    }
    spdlog::warn("{}: cannot accept a connection: {}", options.name, error.message());
    asio::steady_timer pause(strand, kAcceptPause);
    co_await pause.async_wait(Into(error));
  }
}

std::shared_ptr<AcceptedConnection> Listener::State::PickToGiveWay(GivesWay when, uint64_t& id) {
  std::vector<std::pair<uint64_t, std::shared_ptr<AcceptedConnection>>> candidates;
  std::vector<Closable> closable;
  for (const auto& [its_id, entry] : connections) {
    auto connection = entry.connection.lock();
    if (!connection || entry.closing || connection->gives_way() != when) continue;
    closable.push_back({connection->block(), true});
    candidates.emplace_back(its_id, std::move(connection));
  }
  std::optional<size_t> picked = PickToClose(closable);
  if (!picked) return nullptr;
  id = candidates[*picked].first;
  return candidates[*picked].second;
}

// Closing connections no longer count, so a new one need not wait for their end. kMaxClosing keeps
// a flood from opening sockets faster than they close.
bool Listener::State::MakeRoom() {
  if (connections.size() - closing < options.max_connections) return true;
  if (closing >= kMaxClosing) return false;
  uint64_t id = 0;
  auto connection = PickToGiveWay(GivesWay::kFirst, id);
  if (!connection) connection = PickToGiveWay(GivesWay::kAfterOthers, id);
  if (!connection) return false;
  connections.at(id).closing = true;
  ++closing;
  connection->Close();
  return true;
}

void Listener::State::Admit(tcp::socket socket, Strand its) {
  ENAMEL_CHECK(strand.running_in_this_thread());
  if (!MakeRoom()) {
    turn_away(std::move(socket), connections.size());
    return;
  }
  error_code ignored;
  // Answers are written whole: waiting for more to send would only delay their last packet.
  socket.set_option(tcp::no_delay(true), ignored);
  uint64_t id = next_id++;
  const std::string peer = PeerAddress(socket);
  const bool proxied = std::ranges::find(options.proxies, peer) != options.proxies.end();
  auto connection = proxied ? AskProxy(id, std::move(socket), std::move(its), peer)
                            : make(std::move(socket), std::move(its), peer);
  connections[id] = {connection, false, !proxied};
  open = connections.size();
  connection->Run(Ended(id));
}

std::function<void()> Listener::State::Ended(uint64_t id) {
  return [self = shared_from_this(), id] {
    asio::post(self->strand, [self, id] { self->Forget(id); });
  };
}

std::shared_ptr<AcceptedConnection> Listener::State::AskProxy(uint64_t id, tcp::socket socket,
                                                              Strand its,
                                                              const std::string& proxy) {
  // Moved from handler to handler: those of Asio may be copied, a socket not.
  auto then = [self = shared_from_this(), id](tcp::socket from, Strand on,
                                              const std::string& peer) {
    auto held = std::make_shared<tcp::socket>(std::move(from));
    asio::post(self->strand,
               [self, id, held, on, peer] { self->Introduced(id, std::move(*held), on, peer); });
  };
  return std::make_shared<Introduction>(std::move(socket), std::move(its), proxy, options.name,
                                        options.introduction, std::move(then));
}

// The place in `connections` stays, with another connection in it.
void Listener::State::Introduced(uint64_t id, tcp::socket socket, Strand its,
                                 const std::string& peer) {
  ENAMEL_CHECK(strand.running_in_this_thread());
  Entry& entry = connections.at(id);
  // Asked to stop before it existed.
  if (stopping || entry.closing) return Forget(id);
  auto connection = make(std::move(socket), std::move(its), peer);
  entry.connection = connection;
  entry.made = true;
  connection->Run(Ended(id));
}

void Listener::State::Forget(uint64_t id) {
  ENAMEL_CHECK(strand.running_in_this_thread());
  auto at = connections.find(id);
  if (at->second.closing) --closing;
  connections.erase(at);
  open = connections.size();
  if (stopping && connections.empty()) grace.cancel();
}

void Listener::State::VisitAll(const std::function<void(AcceptedConnection&)>& visit,
                               bool made_only) {
  ENAMEL_CHECK(strand.running_in_this_thread());
  for (auto& [id, entry] : connections) {
    if (made_only && !entry.made) continue;
    if (auto connection = entry.connection.lock()) visit(*connection);
  }
}

void Listener::State::StopOnStrand() {
  ENAMEL_CHECK(strand.running_in_this_thread());
  if (stopping) return;
  stopping = true;
  error_code ignored;
  acceptor.close(ignored);
  if (connections.empty()) return;
  VisitAll([](AcceptedConnection& connection) { connection.BeginStop(); });
  grace.expires_after(options.stop);
  grace.async_wait([self = shared_from_this()](error_code cancelled) {
    if (!cancelled) self->VisitAll([](AcceptedConnection& connection) { connection.Close(); });
  });
}

Listener::Listener(asio::io_context& io, ListenerOptions options, Make make, TurnAway turn_away)
    : state_(
          std::make_shared<State>(io, std::move(options), std::move(make), std::move(turn_away))) {}

Result<uint16_t> Listener::Start() {
  // A peer that has left shall be an error of the write, not a signal: OpenSSL writes with
  // write(2).
  std::signal(SIGPIPE, SIG_IGN);
  ENAMEL_RETURN_IF_ERROR(CheckProxies(state_->options.proxies));
  ENAMEL_RETURN_IF_ERROR(state_->Listen());
  const uint16_t port = state_->acceptor.local_endpoint().port();
  asio::co_spawn(state_->strand, state_->Accept(),
                 [state = state_](const std::exception_ptr& failure) {
                   if (failure) {
                     spdlog::error("{}: accepting ended by an exception", state->options.name);
                   }
                 });
  return port;
}

void Listener::Stop() {
  asio::post(state_->strand, [state = state_] { state->StopOnStrand(); });
}

size_t Listener::open() const { return state_->open; }

void Listener::ForEach(std::function<void(AcceptedConnection&)> visit) {
  asio::post(state_->strand,
             [state = state_, visit = std::move(visit)] { state->VisitAll(visit, true); });
}

std::string PeerAddress(const tcp::socket& socket) {
  error_code error;
  auto endpoint = socket.remote_endpoint(error);
  return error ? std::string("unknown") : endpoint.address().to_string();
}

}  // namespace enamel::server
