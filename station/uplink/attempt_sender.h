#pragma once

#include <functional>
#include <map>
#include <optional>

#include "station/spool/spool.h"
#include "station/uplink/bandwidth.h"
#include "station/uplink/remark_box.h"
#include "station/uplink/server_link.h"

namespace enamel::station {

// Whether trying again later may help.
bool IsTransient(const Status& status);
// This side ended it, so it gives no information on the server.
bool IsStopped(const Status& status);
// Only this recording has to wait, until an admin restores something on the server. It is offered
// again for as long as that takes; other recordings continue.
bool IsAwaited(const Status& status);
// Only this recording has to wait, because part of it cannot be read from the station's disk.
bool IsDamaged(const Status& status);
// Only this recording has to wait: the connection still carries the others.
inline bool IsOfOneRecording(const Status& status) {
  return IsAwaited(status) || IsDamaged(status);
}

// Sends from the spool to the server over one connection. At most kWindow chunks wait for an
// acknowledgement, and no more are in memory. Thread safety: none.
class AttemptSender {
 public:
  static constexpr size_t kWindow = 16;
  // Called before each message and at least this often while waiting; a status other than ok ends
  // the call and is returned.
  static constexpr std::chrono::milliseconds kSlice{10};
  using Meanwhile = std::function<Status()>;

  // All must outlive it. `link` is connected; after a transient error that is not IsOfOneRecording,
  // this object is no longer usable. `remarks` receives messages to the chair; null: nobody is
  // there. `held`: whether an attempt's seal waits (Uploader::HoldSeal); none: no seal does.
  using Held = std::function<bool(const Uuid& attempt)>;
  AttemptSender(ServerLink& link, Spool& spool, Bandwidth& bandwidth, Meanwhile meanwhile = {},
                RemarkBox* remarks = nullptr, Held held = {})
      : link_(link),
        spool_(spool),
        bandwidth_(bandwidth),
        meanwhile_(std::move(meanwhile)),
        remarks_(remarks),
        held_(std::move(held)) {}

  // Asks which attempts the server once had and has lost (it was restored from an older backup):
  // they wait in the spool again. Also asks which tickets for later are revoked: they are deleted.
  // Returns the number of attempts. A server that does not know the question has lost none.
  Result<size_t> Offer();

  // Returns tickets that were handed back to the server, and deletes each one that the server
  // answers, whatever the answer. A ticket whose attempt was begun is deleted without asking.
  // Errors: the link's.
  Status ReturnTickets();

  // Sends the spool's chunks of an attempt from where the server says, waits until they are
  // committed there, and seals the attempt if the spool has its seal. Notes the outcome in the
  // spool, including a refusal that trying again cannot change. `yield`, asked between chunks,
  // returns true to end the call early, with everything sent acknowledged. Errors: the link's, the
  // spool's.
  Status Send(const Uuid& attempt, const std::function<bool()>& yield = {});

  // The attempt was resumed: the next Send opens it again.
  void Reopen(const Uuid& attempt) { next_.erase(attempt); }

  // The server's last answer about this attempt said that somebody watches it.
  bool watched(const Uuid& attempt) const { return watched_ == attempt; }
  // Few chunks wait for an acknowledgement, so the network keeps up.
  bool at_ease() const { return waiting_ <= kWindow / 4; }

 private:
  Result<std::vector<Uuid>> UnusedTickets();
  Status SendOnce(const Uuid& attempt, const std::function<bool()>& yield);
  Status SendChunks(const Uuid& attempt, const std::function<bool()>& yield);
  Status TakeAllAcks();
  Status AwaitBandwidth(size_t bytes);
  Status TakeAck();
  Status Meanwhiles() { return meanwhile_ ? meanwhile_() : Status::Ok(); }
  void NoteWatched(const Uuid& attempt, bool watched);

  ServerLink& link_;
  Spool& spool_;
  Bandwidth& bandwidth_;
  const Meanwhile meanwhile_;
  RemarkBox* const remarks_;
  const Held held_;
  std::map<Uuid, uint32_t> next_;  // attempts opened on this connection, and their next chunk
  size_t waiting_ = 0;             // chunks without acknowledgement
  size_t unmarked_ = 0;            // chunks whose commit the spool does not have yet
  std::optional<Uuid> watched_;
};

// Attempts to send: not refused, and not complete on the server.
Result<std::vector<SpooledAttempt>> WaitingAttempts(Spool& spool);

}  // namespace enamel::station
