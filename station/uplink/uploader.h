#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "station/spool/spool.h"
#include "station/uplink/attempt_sender.h"
#include "station/uplink/backoff.h"
#include "station/uplink/live_mailbox.h"
#include "station/uplink/remark_box.h"
#include "station/uplink/server_link.h"

namespace enamel::station {

struct UploaderOptions {
  uint64_t bytes_per_s = 0;  // upper limit in the long run (bandwidth.h); 0: none
  // Deletes what the server has had for long enough, at the start and this often; none: never.
  std::optional<Retention> retention = {};
  std::chrono::steady_clock::duration prune_every = std::chrono::hours(24);
  Backoff::Duration refused_first = Backoff::kRefusedFirst;  // wait after the station was refused
  // While a connection lasts, what the server may have lost since is offered this often.
  std::chrono::steady_clock::duration offer_every = std::chrono::hours(1);
};

// Sends the spool to the server on its own thread, during recording and across broken connections:
// first the attempt being made, then earlier ones. On every connection, and now and then while it
// lasts, it asks which attempts the server lost (AttemptSender::Offer) and sends those again. It
// returns tickets that were handed back (AttemptSender::ReturnTickets).
//
// Waits between tries as in Backoff. A refusal that trying again cannot change stops the upload of
// that attempt only. A refusal of the whole station (unknown, another certificate, another protocol
// version) stops all for some minutes, or until Retry: the address may have led to another server
// for a moment. Recording continues in both cases.
//
// Live: while the server says that somebody watches the attempt being made, its newest moment is
// sent 60 times a second. The latest wins, and none is sent when bandwidth or acknowledgements are
// short, so that chunks never wait for more than the one being written. Thread safety: all methods
// from any thread; the live mailbox has one writer.
class Uploader {
 public:
  static constexpr std::chrono::microseconds kLiveEvery{16'667};
  static constexpr std::chrono::seconds kPingEvery{20};
  // Recordings that wait for an admin or for salvage (IsOfOneRecording) are offered again this
  // often, at the next ping.
  static constexpr std::chrono::minutes kAwaitedEvery{5};

  // Of one attempt.
  struct State {
    uint32_t committed = 0;  // chunks the server has durably
    bool sealed = false;     // everything is on the server
    bool reachable = true;   // the server, as of the last try
    Status problem;          // last failure
    // Waiting is useless: refused for good, or part of it cannot be read here (IsDamaged).
    bool gave_up = false;
  };
  // Of the connection.
  struct Link {
    bool reachable = true;  // as of the last try
    bool refused = false;   // the whole station was refused: next try in minutes, or by Retry
    Status problem;
    uint64_t live_sent = 0, live_dropped = 0;
  };

  Uploader(Credentials credentials, Spool& spool, const UploaderOptions& options = {});
  ~Uploader();  // stops
  Uploader(const Uploader&) = delete;
  Uploader& operator=(const Uploader&) = delete;

  // From now on sends this attempt before all others, and opens it again if it was open before
  // (resumed). `live` may be null.
  void Prefer(const Uuid& attempt, std::shared_ptr<LiveMailbox> live);
  // Sends this attempt's chunks and not its seal, until ReleaseSeal: a second person may still sign
  // its end. In memory only.
  void HoldSeal(const Uuid& attempt);
  void ReleaseSeal(const Uuid& attempt);
  // The spool has new data.
  void Wake();
  // Tries again at once, even after a refusal of the station.
  void Retry();
  State state(const Uuid& attempt) const;
  Link link() const;
  // Messages to the chair of the preferred attempt.
  RemarkBox& remarks() { return remarks_; }
  // Waits until the attempt is sealed on the server, given up, or the server not reachable for
  // `patience`.
  void WaitUntilDone(const Uuid& attempt, std::chrono::milliseconds patience);
  void Stop();

 private:
  void Run();
  Status RunConnection();
  void Say(const Status& status);
  void PruneWhenDue();
  Status SendWaiting(AttemptSender& sender);
  std::optional<Uuid> NextWaiting(std::set<Uuid>& brought);
  void Note(const Uuid& attempt, const Status& status);
  Status Meanwhile(const AttemptSender& sender);
  void SendLive(const AttemptSender& sender);
  Status AwaitWork(AttemptSender& sender);
  Status Ping();
  bool stopping() const;
  bool PreferredWaits();
  bool IsHeld(const Uuid& attempt) const;

  const Credentials credentials_;
  Spool& spool_;
  Bandwidth bandwidth_;                // of the thread
  ServerLink link_;                    // of the thread, but for Cancel
  Backoff backoff_, refused_backoff_;  // of the thread
  RemarkBox remarks_;
  const std::optional<Retention> retention_;
  const std::chrono::steady_clock::duration prune_every_;
  const std::chrono::steady_clock::duration offer_every_;
  std::chrono::steady_clock::time_point prune_due_{};                 // of the thread
  std::string said_;                                                  // of the thread
  std::chrono::steady_clock::time_point live_due_{}, ping_due_{};     // of the thread
  std::optional<std::chrono::steady_clock::time_point> awaited_due_;  // of the thread
  std::chrono::steady_clock::time_point offer_due_{};                 // of the thread

  mutable Mutex mutex_;
  std::condition_variable_any changed_;
  std::map<Uuid, State> states_ ENAMEL_GUARDED_BY(mutex_);
  Link about_link_ ENAMEL_GUARDED_BY(mutex_);
  std::optional<Uuid> preferred_ ENAMEL_GUARDED_BY(mutex_);
  std::shared_ptr<LiveMailbox> live_ ENAMEL_GUARDED_BY(mutex_);
  bool reopen_ ENAMEL_GUARDED_BY(mutex_) = false;
  std::set<Uuid> held_ ENAMEL_GUARDED_BY(mutex_);  // whose seals wait
  bool wake_ ENAMEL_GUARDED_BY(mutex_) = true;
  bool retry_ ENAMEL_GUARDED_BY(mutex_) = false;
  bool stop_ ENAMEL_GUARDED_BY(mutex_) = false;
  // Separate from wake_, which the walk through the attempts consumes: tickets handed back
  // meanwhile are returned after it.
  bool look_for_tickets_ ENAMEL_GUARDED_BY(mutex_) = true;
  std::thread thread_;
};

}  // namespace enamel::station
