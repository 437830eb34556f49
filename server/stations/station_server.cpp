#include "server/stations/station_server.h"

#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/redirect_error.hpp>
#include <set>

#include "common/base/check.h"
#include "common/net/tls.h"
#include "server/net/listener.h"
#include "server/stations/connection.h"

namespace enamel::server::stations {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

// Stations pin a certificate and never resume a session.
void SaveMemory(SSL_CTX* tls) {
  SSL_CTX_set_session_cache_mode(tls, SSL_SESS_CACHE_OFF);
  SSL_CTX_set_num_tickets(tls, 0);
}

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
  State(asio::io_context& io, StationServerOptions o, Services& s, StorePool& p,
        OtherSchools* other)
      : options(std::move(o)),
        services(s),
        others(other),
        pool(p),
        listener(
            io,
            {"station link", options.address, options.port, options.max_connections,
             options.deadlines.stop, options.proxies, options.deadlines.introduction},
            [this](tcp::socket socket, Strand its, const std::string& peer) {
              return Make(std::move(socket), std::move(its), peer);
            },
            [this](const tcp::socket& socket, size_t open) { NoteTurnedAway(socket, open); }),
        strand(asio::make_strand(io)),
        next_look(strand) {}

  std::shared_ptr<AcceptedConnection> Make(tcp::socket socket, Strand its, const std::string& peer);
  void NoteTurnedAway(const tcp::socket& socket, size_t open);
  using Served = std::vector<std::shared_ptr<Services>>;
  asio::awaitable<void> WatchRevoked();
  Result<std::set<StationOfSchool>> Revoked(const Served& served);
  void EndUnserved(const Served& served);
  void EndRevoked(std::set<StationOfSchool> now);
  void StopOnStrand();

  const StationServerOptions options;
  Services& services;
  OtherSchools* const others;
  StorePool& pool;
  std::shared_ptr<SSL_CTX> tls;  // constant after Start
  const std::shared_ptr<LinkBudget> budget =
      options.budget ? options.budget : std::make_shared<LinkBudget>();
  ops::RepeatLog refusals;
  Listener listener;

  // Owned by the strand: looking for revoked stations.
  Strand strand;
  asio::steady_timer next_look;
  std::shared_ptr<const std::set<StationOfSchool>> revoked =
      std::make_shared<std::set<StationOfSchool>>();
  int tell_revoked = 0;  // further looks after which the connections are told
  bool stopping = false;
};

std::shared_ptr<AcceptedConnection> StationServer::State::Make(tcp::socket socket, Strand its,
                                                               const std::string& peer) {
  return std::make_shared<Connection>(std::move(socket), std::move(its), peer, tls.get(),
                                      options.deadlines, services, others, pool, *budget, refusals);
}

void StationServer::State::NoteTurnedAway(const tcp::socket& socket, size_t open) {
  const std::string peer = PeerAddress(socket);
  refusals.Note(peer + " full", "station link: refused a peer at " + peer + ": " +
                                    std::to_string(open) + " connections are open");
}

// A station that asks for nothing would never learn that it was revoked.
asio::awaitable<void> StationServer::State::WatchRevoked() {
  while (!stopping) {
    next_look.expires_after(std::chrono::milliseconds(kAdmittedEveryMs / 2));
    error_code ignored;
    co_await next_look.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
    if (stopping || listener.open() == 0) continue;
    const auto served = others != nullptr ? others->All() : Served{};
    auto now = co_await pool.Run([&] { return Revoked(served); });
    if (now.ok()) EndRevoked(std::move(*now));
    // Read again: one may have been opened, and have a station already.
    if (others != nullptr) EndUnserved(others->All());
  }
}

// Of the own school and these.
Result<std::set<StationOfSchool>> StationServer::State::Revoked(const Served& served) {
  ENAMEL_ASSIGN_OR_RETURN(const auto own, services.store.stations.RevokedStations());
  std::set<StationOfSchool> out;
  for (const Uuid& station : own) out.emplace(&services, station);
  for (const auto& other : served) {
    // A failing school does not keep the others' stations from being ended; its log has the reason.
    const auto theirs = other->store.stations.RevokedStations();
    if (!theirs.ok()) continue;
    for (const Uuid& station : *theirs) out.emplace(other.get(), station);
  }
  return out;
}

void StationServer::State::EndUnserved(const Served& served) {
  auto all = std::make_shared<std::set<const Services*>>();
  for (const auto& other : served) all->insert(other.get());
  listener.ForEach([all](AcceptedConnection& connection) {
    static_cast<Connection&>(connection).EndUnlessServed(all);  // Make made it
  });
}

// Twice: a connection may just be saying Hello.
void StationServer::State::EndRevoked(std::set<StationOfSchool> now) {
  ENAMEL_CHECK(strand.running_in_this_thread());
  if (now != *revoked) {
    revoked = std::make_shared<const std::set<StationOfSchool>>(std::move(now));
    tell_revoked = 2;
  }
  if (tell_revoked == 0) return;
  --tell_revoked;
  listener.ForEach([revoked = revoked](AcceptedConnection& connection) {
    static_cast<Connection&>(connection).EndIfRevoked(revoked);  // Make made it
  });
}

void StationServer::State::StopOnStrand() {
  stopping = true;
  next_look.cancel();
}

StationServer::StationServer(asio::io_context& io, StationServerOptions options, Services& services,
                             StorePool& pool, OtherSchools* others)
    : state_(std::make_shared<State>(io, std::move(options), services, pool, others)) {}

StationServer::~StationServer() { Stop(); }

Result<uint16_t> StationServer::Start() {
  State& s = *state_;
  ENAMEL_ASSIGN_OR_RETURN(auto tls,
                          net::MakeServerContext(s.options.certificate, s.options.private_key));
  s.tls = tls;
  SaveMemory(tls.get());
  AllowDescriptors();
  ENAMEL_ASSIGN_OR_RETURN(auto port, s.listener.Start());
  asio::co_spawn(s.strand, s.WatchRevoked(), [state = state_](std::exception_ptr failure) {
    if (failure) spdlog::error("station link: looking for revoked stations ended by an exception");
  });
  return port;
}

void StationServer::Stop() {
  state_->listener.Stop();
  asio::post(state_->strand, [state = state_] { state->StopOnStrand(); });
}

}  // namespace enamel::server::stations
