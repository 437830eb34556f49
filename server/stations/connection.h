#pragma once

#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "common/base/log_request.h"
#include "common/protocol/frame.h"
#include "server/net/deadline.h"
#include "server/net/listener.h"
#include "server/net/stream_socket.h"
#include "server/ops/repeat_log.h"
#include "server/stations/link_budget.h"
#include "server/stations/session.h"
#include "server/stations/station_server.h"

namespace enamel::server::stations {

// One station's connection. Two coroutines on its strand: one serves, the other closes the socket
// when the first one's deadline has passed. Private members belong to the strand; public functions
// may be called from any thread, and post to it.
class Connection : public AcceptedConnection, public std::enable_shared_from_this<Connection> {
 public:
  // Requires: the socket runs on `strand`. `tls`, `deadlines` and what follows outlive it.
  Connection(boost::asio::ip::tcp::socket socket, Strand strand, std::string peer, SSL_CTX* tls,
             const LinkDeadlines& deadlines, Services& services, OtherSchools* others,
             StorePool& pool, LinkBudget& budget, ops::RepeatLog& refusals);

  void Run(std::function<void()> on_end) override;
  // Sends the peer word that the server stops.
  void BeginStop() override;
  void Close() override;
  // A station whose Hello succeeded stays.
  GivesWay gives_way() const override { return welcomed_ ? GivesWay::kNever : GivesWay::kFirst; }
  const std::string& block() const override { return block_; }
  // As BeginStop, if the station is one of these: it learns that it was revoked.
  void EndIfRevoked(std::shared_ptr<const std::set<StationOfSchool>> revoked);
  // As BeginStop, for a newer connection of the same station.
  void EndForNewer();
  // As BeginStop, where another school serves it than these.
  void EndUnlessServed(std::shared_ptr<const std::set<const Services*>> served);

 private:
  using Clock = std::chrono::steady_clock;
  using Io = StreamSocket::Io;

  boost::asio::awaitable<void> Serve();
  boost::asio::awaitable<void> ServeRequests();
  boost::asio::awaitable<Result<Bytes>> ReadFrame();
  boost::asio::awaitable<bool> Write(wire::Reply reply);
  // Memory for a frame that has only begun to come. Errors: kUnavailable.
  Status HoldFrame();
  // Refuses the frame that `given_up` was memory for. From any thread.
  void BreakOff(const HeldBytes::Held* given_up);
  Status TooMuchComing() const;
  // Errors: kUnavailable (LinkBudget::Recorded).
  Status CountChunk(const wire::Request& request);
  // Before the first request is carried out: which school's it is.
  boost::asio::awaitable<Status> FindSchool(const wire::Request& first);
  // What `work` gives. Until then the station is sent StillWaiting to `reply_to`.
  template <typename T>
  boost::asio::awaitable<T> Waited(uint32_t reply_to, boost::asio::awaitable<T> work);
  // Runs `work` on one of the store's threads in the party's turn.
  template <typename Work>
  auto InStore(Work work);
  // Waits until the station's share of the time is free again.
  boost::asio::awaitable<void> Rest();
  boost::asio::awaitable<Answer> Carry(const wire::Request& request);
  boost::asio::awaitable<void> Refuse(Status status);
  // Logs it, and removes the parts that are for the log alone.
  void NoteRefusal(wire::Error& error, const Uuid& attempt = {});
  void End(Status why);

  const Strand strand_;
  const LinkDeadlines& deadlines_;
  StorePool& pool_;
  LinkBudget& budget_;
  ops::RepeatLog& refusals_;
  StreamSocket stream_;
  Deadline deadline_;
  protocol::FrameReader reader_;
  const std::string peer_, block_;
  const std::string id_ = LogRequest::NewId();  // what the log calls all its requests
  Services& own_;
  OtherSchools* const others_;
  std::atomic<bool> welcomed_{false};
  // Since the first request.
  std::shared_ptr<Services> services_;
  std::optional<Session> session_;
  bool introduced_ = false;                 // a first message was read
  bool waiting_for_frame_ = false;          // for a frame's first byte
  bool broken_off_ = false;                 // the frame that is coming
  std::optional<Status> ending_;            // why no further request is read
  std::optional<StationOfSchool> station_;  // since Welcome
  // Whose the work is that threads are shared out for: the station, before Welcome the address.
  std::string party_;
  Clock::duration took_{};  // by requests that the station has not been charged for
  std::shared_ptr<HeldBytes::Held> coming_;  // of a large frame that has not arrived yet
};

}  // namespace enamel::server::stations
