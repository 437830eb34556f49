#pragma once

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <memory>
#include <optional>
#include <set>

#include "common/protocol/frame.h"
#include "server/ops/refusal_log.h"
#include "server/stations/session.h"
#include "server/stations/station_server.h"
#include "server/stations/tls_socket.h"

namespace enamel::server::stations {

// One station's connection. Two coroutines on its strand: one serves, one closes the socket when
// the deadline of what the first waits for has passed. Everything here is touched on the strand
// only, except BeginStop and Close, which post to it.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  // Requires: the socket's executor is a strand of its own. `tls`, `deadlines` and what follows
  // outlive it.
  Connection(boost::asio::ip::tcp::socket socket, SSL_CTX* tls, const LinkDeadlines& deadlines,
             Services& services, StorePool& pool, ops::RefusalLog& refusals);

  // Serves until either side ends it. Call once.
  void Run(std::function<void()> on_end);
  // Finish the request in progress, say why, close. Any thread.
  void BeginStop();
  // The same for a station that is one of these. Any thread.
  void EndIfRevoked(std::shared_ptr<const std::set<Uuid>> revoked);
  // Close now. Any thread.
  void Close();
  // Any thread: has said Hello with success; whom it counts for (auth::AddressBlock).
  bool welcomed() const { return welcomed_; }
  const std::string& block() const { return block_; }

 private:
  using Clock = std::chrono::steady_clock;
  using Io = TlsSocket::Io;

  boost::asio::awaitable<void> Serve();
  boost::asio::awaitable<void> ServeRequests();
  boost::asio::awaitable<void> Watch();
  boost::asio::awaitable<Result<Bytes>> ReadFrame();
  boost::asio::awaitable<bool> Write(wire::Reply reply);
  boost::asio::awaitable<Answer> Carry(const wire::Request& request);
  boost::asio::awaitable<void> Refuse(Status status);
  // Says it in the log, and takes out of it what is for the log alone.
  void NoteRefusal(wire::Error& error);
  void Allow(std::chrono::milliseconds time);
  void End(Status why);
  void CloseSocket();

  const LinkDeadlines& deadlines_;
  StorePool& pool_;
  ops::RefusalLog& refusals_;
  TlsSocket stream_;
  Clock::time_point deadline_;
  boost::asio::steady_timer watch_;  // wakes Watch, never later than the deadline
  protocol::FrameReader reader_;
  const std::string peer_, block_;
  std::atomic<bool> welcomed_{false};
  Session session_;
  bool introduced_ = false;         // a first message was read
  bool waiting_for_frame_ = false;  // for a frame's first byte
  std::optional<Status> ending_;    // why no further request is read
  std::optional<Uuid> station_;     // since Welcome
  bool ended_ = false;
};

}  // namespace enamel::server::stations
