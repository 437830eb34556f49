#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/stations/session.h"
#include "server/storage/store_pool.h"

namespace enamel::server::stations {

class LinkBudget;

// schemas/wire/README.md, "Deadlines".
struct LinkDeadlines {
  std::chrono::milliseconds introduction{10'000};  // TLS handshake and first message
  std::chrono::milliseconds idle{60'000};          // between frames
  std::chrono::milliseconds frame{30'000};         // from a frame's first byte to its last
  std::chrono::milliseconds work{60'000};          // a request in the store
  std::chrono::milliseconds still_waiting{1'000};  // between two StillWaiting meanwhile
  std::chrono::milliseconds write{30'000};
  std::chrono::milliseconds stop{5'000};  // what a request gets to finish in when stopping
};

struct StationServerOptions {
  std::string address = "127.0.0.1";               // numeric
  uint16_t port = 8443;                            // 0: any free one
  std::filesystem::path certificate, private_key;  // PEM
  // Proxies that pass the bytes on and name the peer (ListenerOptions): the station's TLS still
  // ends here.
  std::vector<std::string> proxies;
  // For one more, one that has not said Hello yet is closed: the first of the address that has the
  // most of them. When there is none, the one more is closed.
  size_t max_connections = 16'384;
  LinkDeadlines deadlines;
  std::shared_ptr<LinkBudget> budget{};  // null: one with the defaults
};

// The other schools whose stations use the same link. Thread safety: any thread.
class OtherSchools {
 public:
  virtual ~OtherSchools() = default;
  // The school of a station with this first message, or whose enrolment code it has; null: no other
  // school's. May block. Errors: kUnavailable (it may belong to a suspended one).
  virtual Result<std::shared_ptr<Services>> ServicesOf(const wire::Request& first) = 0;
  // Of all that are served now. A connection to one that is no longer among them ends.
  virtual std::vector<std::shared_ptr<Services>> All() = 0;
};

// The station link: TLS 1.3, one coroutine on one strand per connection, which alone owns the
// stream, its buffers and its Session. Requests are carried out in order, one at a time, and
// answered before the next is read, so that at most one frame in and one frame out are held per
// connection.
//
// Lifetime: services, pool and other schools outlive the server, the server outlives the running of
// `io`. Thread safety: Start once; Stop from any thread, any number of times; `io` may run on any
// number of threads.
class StationServer {
 public:
  // `others`: null: it is one school's.
  StationServer(boost::asio::io_context& io, StationServerOptions options, Services& services,
                StorePool& pool, OtherSchools* others = nullptr);
  ~StationServer();

  // Listens; returns the port. From then on this process ignores SIGPIPE and may open as many files
  // as its hard limit allows. Errors: kInvalidInput (address), kUnavailable (port in use), those
  // of the certificate.
  Result<uint16_t> Start();

  // Returns at once. Refuses new connections and requests, then notifies and closes idle ones;
  // after deadlines.stop it closes the rest. `io` then has no work of this server.
  void Stop();

 private:
  struct State;
  std::shared_ptr<State> state_;  // shared with the connections' coroutines
};

}  // namespace enamel::server::stations
