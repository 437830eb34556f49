#include "server/stations/station_server.h"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl/context.hpp>
#include <csignal>
#include <map>
#include <set>

#include "common/net/tls.h"
#include "server/ops/full_house.h"
#include "server/stations/connection.h"

namespace enamel::server::stations {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr size_t kMaxLeaving = 64;

// Idle connections keep no record buffers; stations pin a certificate and never resume a session.
void SaveMemory(SSL_CTX* tls) {
  SSL_CTX_set_mode(tls, SSL_MODE_RELEASE_BUFFERS | SSL_MODE_ENABLE_PARTIAL_WRITE |
                            SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  SSL_CTX_set_session_cache_mode(tls, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_num_tickets(tls, 0);
}

// A peer that is gone shall be an error of the write, not a signal: OpenSSL writes with write(2).
void IgnoreBrokenPipes() { std::signal(SIGPIPE, SIG_IGN); }

// As many as the system lets this process have: one each.
void AllowDescriptors() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == limit.rlim_max) return;
  limit.rlim_cur = limit.rlim_max;
  if (::setrlimit(RLIMIT_NOFILE, &limit) != 0) {
    spdlog::warn("station link: cannot raise the limit of open files; see ulimit -n");
  }
}

}  // namespace

struct StationServer::State : std::enable_shared_from_this<State> {
  State(asio::io_context& context, StationServerOptions o, Services& s, StorePool& p)
      : io(context),
        options(std::move(o)),
        services(s),
        pool(p),
        strand(asio::make_strand(io)),
        acceptor(strand),
        grace(strand),
        next_look(strand) {}

  asio::awaitable<void> Accept();
  asio::awaitable<void> WatchRevoked();
  void EndRevoked(std::set<Uuid> now);
  bool HasRoom();  // or makes some
  void Admit(tcp::socket socket);
  void Forget(uint64_t id);
  void StopOnStrand();

  asio::io_context& io;
  const StationServerOptions options;
  Services& services;
  StorePool& pool;
  std::shared_ptr<asio::ssl::context> tls;
  ops::RefusalLog refusals{"station link"};
  // Owned by the strand.
  asio::strand<asio::io_context::executor_type> strand;
  tcp::acceptor acceptor;
  asio::steady_timer grace;
  asio::steady_timer next_look;  // of WatchRevoked
  std::shared_ptr<const std::set<Uuid>> revoked = std::make_shared<std::set<Uuid>>();
  int tell_revoked = 0;  // further looks after which the connections are told
  std::map<uint64_t, std::weak_ptr<Connection>> connections;
  std::set<uint64_t> leaving;  // those that make room and are not gone yet
  uint64_t next_id = 0;
  bool stopping = false;
};

asio::awaitable<void> StationServer::State::Accept() {
  while (!stopping) {
    error_code error;
    tcp::socket socket(asio::make_strand(io));
    co_await acceptor.async_accept(socket, asio::redirect_error(asio::use_awaitable, error));
    if (!error) {
      Admit(std::move(socket));
      continue;
    }
    if (stopping || error == asio::error::operation_aborted) co_return;
    // Out of descriptors, most likely: give the others time to go.
    spdlog::warn("station link: cannot accept a connection: {}", error.message());
    asio::steady_timer pause(strand, std::chrono::milliseconds(100));
    co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, error));
  }
}

// A station that asks for nothing would never learn that it was revoked.
asio::awaitable<void> StationServer::State::WatchRevoked() {
  while (!stopping) {
    next_look.expires_after(std::chrono::milliseconds(kAdmittedEveryMs / 2));
    error_code ignored;
    co_await next_look.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    if (stopping || connections.empty()) continue;
    auto now = co_await pool.Run([this] { return services.store.RevokedStations(); });
    if (now.ok()) EndRevoked({now->begin(), now->end()});
  }
}

// Twice: a connection may just be saying Hello.
void StationServer::State::EndRevoked(std::set<Uuid> now) {
  if (now != *revoked) {
    revoked = std::make_shared<const std::set<Uuid>>(std::move(now));
    tell_revoked = 2;
  }
  if (tell_revoked == 0) return;
  --tell_revoked;
  for (auto& [id, weak] : connections) {
    if (auto connection = weak.lock()) connection->EndIfRevoked(revoked);
  }
}

// Full: of those who have not said who they are, one goes.
bool StationServer::State::HasRoom() {
  if (connections.size() - leaving.size() < options.max_connections) return true;
  if (leaving.size() >= kMaxLeaving) return false;
  std::vector<std::pair<uint64_t, std::shared_ptr<Connection>>> all;
  std::vector<ops::Guest> guests;
  for (auto& [id, weak] : connections) {
    auto connection = weak.lock();
    if (!connection || connection->welcomed() || leaving.contains(id)) continue;
    guests.push_back({connection->block(), true});
    all.emplace_back(id, std::move(connection));
  }
  std::optional<size_t> goes = ops::WhoMakesRoom(guests);
  if (!goes) return false;
  leaving.insert(all[*goes].first);
  all[*goes].second->Close();
  return true;
}

void StationServer::State::Admit(tcp::socket socket) {
  if (!HasRoom()) {
    error_code error;
    auto peer = socket.remote_endpoint(error);
    refusals.Note({"a peer at " + (error ? std::string("?") : peer.address().to_string()), "full",
                   std::to_string(connections.size()) + " connections are open"});
    return;
  }
  error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  uint64_t id = next_id++;
  auto connection = std::make_shared<Connection>(std::move(socket), tls->native_handle(),
                                                 options.deadlines, services, pool, refusals);
  connections[id] = connection;
  connection->Run([self = shared_from_this(), id] {
    asio::post(self->strand, [self, id] { self->Forget(id); });
  });
}

void StationServer::State::Forget(uint64_t id) {
  connections.erase(id);
  leaving.erase(id);
  if (stopping && connections.empty()) grace.cancel();
}

void StationServer::State::StopOnStrand() {
  if (stopping) return;
  stopping = true;
  error_code ignored;
  acceptor.close(ignored);
  next_look.cancel();
  if (connections.empty()) return;
  for (auto& [id, weak] : connections) {
    if (auto connection = weak.lock()) connection->BeginStop();
  }
  grace.expires_after(options.deadlines.stop);
  grace.async_wait([self = shared_from_this()](error_code cancelled) {
    if (cancelled) return;
    for (auto& [id, weak] : self->connections) {
      if (auto connection = weak.lock()) connection->Close();
    }
  });
}

StationServer::StationServer(asio::io_context& io, StationServerOptions options, Services& services,
                             StorePool& pool)
    : state_(std::make_shared<State>(io, std::move(options), services, pool)) {}

StationServer::~StationServer() { Stop(); }

Result<uint16_t> StationServer::Start() {
  State& s = *state_;
  ENAMEL_ASSIGN_OR_RETURN(auto tls,
                          net::MakeServerContext(s.options.certificate, s.options.private_key));
  s.tls = tls;
  SaveMemory(tls->native_handle());
  AllowDescriptors();
  IgnoreBrokenPipes();
  error_code error;
  auto address = asio::ip::make_address(s.options.address, error);
  if (error) {
    return Status(Code::kInvalidInput,
                  "expected a numeric address to listen on, found \"" + s.options.address + "\"");
  }
  tcp::endpoint endpoint(address, s.options.port);
  s.acceptor.open(endpoint.protocol(), error);
  if (!error) s.acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) s.acceptor.bind(endpoint, error);
  if (!error) s.acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    return Status(Code::kUnavailable,
                  "cannot listen for stations on " + s.options.address + ":" +
                      std::to_string(s.options.port) + ": " + error.message() +
                      "; stop the program that uses the port or name another one");
  }
  asio::co_spawn(s.strand, s.Accept(), [state = state_](std::exception_ptr failure) {
    if (failure) spdlog::error("station link: accepting ended by an exception");
  });
  asio::co_spawn(s.strand, s.WatchRevoked(), [state = state_](std::exception_ptr failure) {
    if (failure) spdlog::error("station link: looking for revoked stations ended by an exception");
  });
  return s.acceptor.local_endpoint().port();
}

void StationServer::Stop() {
  asio::post(state_->strand, [state = state_] { state->StopOnStrand(); });
}

}  // namespace enamel::server::stations
