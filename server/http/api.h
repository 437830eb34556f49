#pragma once

#include <array>
#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "server/auth/authenticator.h"
#include "server/http/feel_maps.h"
#include "server/http/message.h"
#include "server/http/routes.h"
#include "server/storage/store.h"
#include "server/storage/store_pool.h"

namespace enamel::server::http {

// From request to answer, without a socket: route, same-site check, session, role, CSRF, handler,
// in this order. Thread safety: Handle from any strand; the work itself runs on the store's
// threads, so no I/O thread ever blocks. At most `max_in_flight` requests wait for those threads;
// more get 503. Health has a thread of its own: it answers while those wait.
class Api {
 public:
  Api(Store& store, auth::Authenticator& authenticator, Monitoring monitoring, size_t threads,
      size_t max_in_flight);

  // Attempts can be watched from now on. Before the first Handle.
  void Show(LiveBoard& live) { live_ = &live; }
  // Stations can be enrolled from now on: what they know the server by. Before the first Handle.
  void Enrol(std::string station_fingerprint) {
    station_fingerprint_ = std::move(station_fingerprint);
  }
  // Whether whoever asked for the events may still see them; on the store's threads.
  boost::asio::awaitable<bool> StillAllowed(EventSource& events);

  // True for paths that are never the page's.
  static bool Owns(std::string_view path);

  boost::asio::awaitable<Response> Handle(const Request& request);

  // Answers so far by the first digit of their status (index 1 to 5), how long reads (GET,
  // HEAD) took from the whole request to the answer, and requests without the right to them.
  const std::array<std::atomic<uint64_t>, 6>& answers() const { return answers_; }
  const ops::Histogram& reads() const { return reads_; }
  const auth::DoorCounts& door() const { return authenticator_.counts(); }
  uint64_t forbidden() const { return forbidden_; }

 private:
  boost::asio::awaitable<Response> Answer(const Request& request);
  boost::asio::awaitable<Response> Asynchronous(Call& call, const Route& route);
  Response Blocking(Call& call, const Route& route);
  Result<auth::Identity> Identify(const Request& request);
  void NoteForbidden(const Call& call, const Route& route, const Response& response);

  Store& store_;
  auth::Authenticator& authenticator_;
  const Monitoring monitoring_;
  const size_t max_in_flight_;
  LiveBoard* live_ = nullptr;
  std::string station_fingerprint_;
  std::atomic<size_t> in_flight_{0};
  std::array<std::atomic<uint64_t>, 6> answers_{};
  std::atomic<uint64_t> forbidden_{0};
  ops::Histogram reads_;
  StorePool pool_;
  StorePool apart_{1};
  FeelMaps feel_;
};

}  // namespace enamel::server::http
