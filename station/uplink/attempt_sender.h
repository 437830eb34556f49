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
// It was ended from this side: nothing is known of the server by that.
bool IsStopped(const Status& status);
// Only this recording has to wait, for what an admin has to bring back to the server; it is offered
// again, however long that takes, and others go on.
bool IsAwaited(const Status& status);
// Only this recording has to wait, as not all of it can be read from the station's disk.
bool IsDamaged(const Status& status);
// Only this recording has to wait: the connection carries the others.
inline bool IsOfOneRecording(const Status& status) {
  return IsAwaited(status) || IsDamaged(status);
}

// What one connection carries from the spool to the server. At most kWindow chunks are on their way
// without acknowledgement, and no more is in memory. Thread safety: none.
class AttemptSender {
 public:
  static constexpr size_t kWindow = 16;
  // Called before each message and at least this often while waiting; not ok: the call ends with
  // it.
  static constexpr std::chrono::milliseconds kSlice{10};
  using Meanwhile = std::function<Status()>;

  // All must outlive it. `link` is connected; after a transient error that is not
  // IsOfOneRecording this is of no more use. `remarks`: where those to the chair go; null: nobody is
  // there.
  AttemptSender(ServerLink& link, Spool& spool, Bandwidth& bandwidth, Meanwhile meanwhile = {},
                RemarkBox* remarks = nullptr)
      : link_(link),
        spool_(spool),
        bandwidth_(bandwidth),
        meanwhile_(std::move(meanwhile)),
        remarks_(remarks) {}

  // Asks which of the attempts that the server once had it has no more (it was restored from an
  // older backup): the spool has them wait again; and which tickets for later are revoked: they are
  // forgotten. Returns how many attempts. A server that does not know the question has all of them.
  Result<size_t> Offer();

  // Tells the server of the tickets that were handed back, and forgets those that it answers about,
  // whatever it says. One whose attempt was begun is forgotten without asking. Errors: the link's.
  Status ReturnTickets();

  // Sends what the spool has of an attempt now, from where the server says, waits until it is
  // committed there, and seals it when the spool has its seal. How it went is noted in the spool.
  // `yield`, asked between chunks, returning true ends it earlier, with everything sent
  // acknowledged. A refusal that trying again cannot change is noted in the spool. Errors: the
  // link's, the spool's.
  Status Send(const Uuid& attempt, const std::function<bool()>& yield = {});

  // The next Send opens the attempt anew: it was resumed.
  void Reopen(const Uuid& attempt) { next_.erase(attempt); }

  // The server said with its last answer about this attempt that somebody watches it.
  bool watched(const Uuid& attempt) const { return watched_ == attempt; }
  // Few chunks wait for an acknowledgement: the network keeps up.
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
  std::map<Uuid, uint32_t> next_;  // attempts opened on this connection, and their next chunk
  size_t waiting_ = 0;             // chunks without acknowledgement
  size_t unmarked_ = 0;            // chunks that the spool does not know of yet to be committed
  std::optional<Uuid> watched_;
};

// The attempts that are to be sent: not refused, and with something the server does not have.
Result<std::vector<SpooledAttempt>> WaitingAttempts(Spool& spool);

}  // namespace enamel::station
