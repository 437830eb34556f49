#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/auth/authenticator.h"
#include "server/auth/first_admin.h"
#include "server/jobs/backup_run.h"
#include "server/live/live_board.h"
#include "server/live/station_board.h"
#include "server/net/held_bytes.h"
#include "server/ops/budgets.h"
#include "server/ops/metrics.h"
#include "server/storage/store.h"
#include "server/storage/upkeep/readiness.h"

namespace enamel::server::http {

class Api;

// Another school that this server's page is for, under host names of its own.
struct OtherSchool {
  std::shared_ptr<Api> api;                        // null: it is not served now
  bool suspended = false;                          // that is why
  std::shared_ptr<const std::atomic<bool>> ended;  // Request::school_ended
};

struct TlsFiles {
  std::filesystem::path certificate_chain;  // PEM, the server's own first
  std::filesystem::path private_key;        // PEM
};

// Deadlines of a connection; each covers the whole of its phase, so a byte now and then does not
// extend it.
struct HttpDeadlines {
  // Between requests. Chromium gives up a connection that it opened ahead after 60 s
  // (ClientSocketPoolManager::unused_idle_socket_timeout). If the server closes it first, a request that Chromium has just
  // sent on it fails before the user.
  std::chrono::milliseconds idle{75'000};
  std::chrono::milliseconds handshake{10'000};  // TLS
  std::chrono::milliseconds head{10'000};       // from a head's first byte to its last
  std::chrono::milliseconds body{30'000};
  // An API request, from its last byte to its answer: afterwards it gets 503, and work not yet
  // begun is dropped.
  std::chrono::milliseconds work{60'000};
  std::chrono::milliseconds write{60'000};
  std::chrono::milliseconds event{5'000};     // one event to a viewer: who is slower is dropped
  std::chrono::milliseconds events{300'000};  // a stream; its viewer comes back, and is asked again
  std::chrono::milliseconds allowed{
      2'000};                             // until it is asked again whether its viewer may see it
  std::chrono::milliseconds stop{5'000};  // what a request gets to finish in when stopping
};

struct HttpOptions {
  std::string address = "127.0.0.1";  // numeric; anything but loopback needs `tls` or a proxy
  uint16_t port = 8080;               // 0: any free one
  std::optional<TlsFiles> tls;        // TLS 1.3
  // Numeric addresses of the proxies in front of this server, which then answers nobody else and
  // may speak plain HTTP beyond loopback: they speak TLS to the browsers (TakeFromProxy).
  std::vector<std::string> trusted_proxies;
  std::filesystem::path web_root;  // the built page; empty: API only
  // Names the page may be asked for under, lower case, without port. Empty: 127.0.0.1, localhost
  // and [::1]; required when `address` is not loopback, and behind a proxy.
  std::vector<std::string> host_names;
  // The school of a host name (lower case, without port) that is none of `host_names`; none:
  // unknown. From any thread; must not block.
  std::function<std::optional<OtherSchool>(const std::string& host)> other_schools;
  // For one more, the one of those that wait for a request, or do not take an answer, is closed
  // that came first from the address that has the most of them; when there is none, the one more is
  // closed with 503. Viewers of live streams are not closed for it.
  size_t max_connections = 1024;
  size_t max_in_flight = 64;  // requests waiting for the store's threads
  size_t store_threads = 4;
  HttpDeadlines deadlines;
  // How often PageTls looks at the files of `tls`.
  std::chrono::milliseconds certificates{30'000};
  // Of the certificate that stations know this server by, in hexadecimal: what an enrolment code is
  // given out with. Empty: none are given out.
  std::string station_fingerprint;
  BackupRun::Place backups{};               // that people start
  auth::FirstAdmin* first_admin = nullptr;  // of a server that has no admin
  // Connected stations and remarks to their chairs; none: it takes none.
  StationBoard* stations = nullptr;
  LiveBoard* live = nullptr;  // what /attempts/{id}/live shows; none: there is no such path
  // GET /metrics is for this machine, or with a token for whoever has it. No metrics: no such path.
  // The server adds its own figures to them.
  ops::Metrics* metrics = nullptr;
  std::string metrics_token;
  ops::Budgets budgets{};
  std::shared_ptr<HeldBytes> bodies{};  // that have begun to come; null: its own
  std::function<std::vector<ops::BudgetUse>()> budgets_used{};  // Monitoring::budgets
  // What the school's other servers measure (Monitoring::peers); none: there are none.
  std::function<std::optional<PeersView>()> peers{};
};

// Serves the API (schemas/api/openapi.yaml) and the page. One coroutine on one strand per
// connection, which alone owns the stream and its buffers; blocking work runs on threads of its own
// (Api).
//
// Lifetime: store and authenticator outlive the server, the server outlives the running of `io`.
// Thread safety: Start once; Stop from any thread, any number of times; `io` may run on any number
// of threads.
class HttpServer {
 public:
  HttpServer(boost::asio::io_context& io, HttpOptions options, Store& store,
             auth::Authenticator& authenticator);
  // Requires: `io` does not run any more, or has run out of work.
  ~HttpServer();

  // Listens; returns the port. Errors: kInvalidInput (address, host names, plain HTTP beyond
  // loopback), kUnavailable (port in use), kNotFound (page, certificate), each with what to do.
  Result<uint16_t> Start();

  // Where stations reach this server: an enrolment code is given out with it. From any thread.
  void StationsListenAt(uint16_t port);

  // GET /readyz is 404 from now on, so that whoever shares out the requests sends no more; those
  // that come are answered. From any thread.
  void Drain();

  // Returns at once. Refuses new connections and requests, and closes idle ones; after
  // deadlines.stop it closes the rest. `io` then has no work of this server.
  void Stop();

 private:
  struct State;
  std::shared_ptr<State> state_;  // shared with the connections' coroutines
};

}  // namespace enamel::server::http
