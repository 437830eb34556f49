#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/strand.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/result.h"

namespace enamel::server {

using Strand = boost::asio::strand<boost::asio::io_context::executor_type>;

// When a connection is closed to let one more in.
enum class GivesWay : uint8_t { kNever, kAfterOthers, kFirst };

// A connection, as its listener sees it. Thread safety: all of it from any thread.
class AcceptedConnection {
 public:
  virtual ~AcceptedConnection() = default;
  // Serves until either side ends it, and then calls `on_end` once. Keeps itself alive until then.
  // Called once.
  virtual void Run(std::function<void()> on_end) = 0;
  // Finish the request in progress, take no other, close.
  virtual void BeginStop() = 0;
  // Close now.
  virtual void Close() = 0;
  virtual GivesWay gives_way() const = 0;
  // The address it counts for (auth::AddressBlock). Constant.
  virtual const std::string& block() const = 0;
};

struct ListenerOptions {
  std::string name;     // begins its lines in the log
  std::string address;  // numeric
  uint16_t port = 0;    // 0: any free one
  // For one more, one of those that give way first is closed, else one of those that do so after
  // others: the oldest of the address that has the most of them (connection_limit.h). When there is
  // none, the one more is turned away.
  size_t max_connections = 1024;
  std::chrono::milliseconds stop{5'000};  // what a request gets to finish in when stopping
  // Numeric addresses of proxies that name their own peer (proxy_header.h): each of their
  // connections begins with that header, or with TLS: then its peer is "". It is not read from other
  // peers.
  std::vector<std::string> proxies = {};
  std::chrono::milliseconds introduction{10'000};  // what a proxy gets to say it in
};

// Accepts connections, each on a strand of its own, bounds their number, and stops them in two
// phases. Knows nothing of their content.
//
// Bounded: max_connections, and at most kMaxClosing more that are closing. Lifetime: what `make`
// and `turn_away` use outlives the running of `io`. Thread safety: Start once; everything else from
// any thread; `io` may run on any number of threads.
class Listener {
 public:
  static constexpr size_t kMaxClosing = 64;

  // `socket` runs on `strand`; `peer`: numeric, behind a proxy the proxy's peer.
  using Make = std::function<std::shared_ptr<AcceptedConnection>(
      boost::asio::ip::tcp::socket socket, Strand strand, const std::string& peer)>;
  // For a socket that finds no room; `open` connections are open. Must not block.
  using TurnAway = std::function<void(boost::asio::ip::tcp::socket socket, size_t open)>;

  Listener(boost::asio::io_context& io, ListenerOptions options, Make make, TurnAway turn_away);

  // Listens; returns the port. Errors: kInvalidInput (address, proxies), kUnavailable (port in
  // use).
  Result<uint16_t> Start();

  // Returns at once; a repeated call changes nothing. Refuses new connections and calls BeginStop
  // for the open ones; after options.stop it closes the rest. `io` then has no work of this
  // listener.
  void Stop();

  // Connections that have not ended, including those that are closing.
  size_t open() const;
  // Calls `visit` later, from a strand, for each connection that `make` made and that has not ended
  // by then.
  void ForEach(std::function<void(AcceptedConnection&)> visit);

 private:
  struct State;
  std::shared_ptr<State> state_;  // shared with what waits in `io`
};

// Numeric; "unknown" when the peer has already left.
std::string PeerAddress(const boost::asio::ip::tcp::socket& socket);

}  // namespace enamel::server
