#include "station/uplink/attempt_sender.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "common/protocol/messages.h"
#include "common/protocol/refusals.h"

namespace enamel::station {
namespace {

// Half of the server's limit for one message, so that attempts and tickets fit together.
constexpr size_t kOfferAtOnce = 512;
using Clock = std::chrono::steady_clock;

}  // namespace

// A server whose disk is full (kStorage) or that failed internally (kInternal) may recover without
// this station; any other answer it will repeat.
bool IsTransient(const Status& status) {
  return status.code() == Code::kUnavailable || status.code() == Code::kStorage ||
         status.code() == Code::kInternal;
}

bool IsStopped(const Status& status) {
  return status.code() == Code::kUnavailable && status.field() == net::kCancelled;
}

bool IsAwaited(const Status& status) {
  return status.code() == Code::kUnavailable && status.field() == protocol::kAwaited;
}

bool IsDamaged(const Status& status) {
  return status.code() == Code::kStorage && status.field() == kDamagedSpool;
}

Result<std::vector<SpooledAttempt>> WaitingAttempts(Spool& spool) {
  auto all = spool.List();
  // A refused recording is not offered again until ClearRefusal makes it wait.
  if (all.ok()) std::erase_if(*all, [](const SpooledAttempt& a) { return !a.waits(); });
  return all;
}

Result<size_t> AttemptSender::Offer() {
  ENAMEL_ASSIGN_OR_RETURN(auto all, spool_.List());
  std::erase_if(all, [](const SpooledAttempt& a) { return !a.complete() || !a.refused.empty(); });
  ENAMEL_ASSIGN_OR_RETURN(auto tickets, UnusedTickets());
  size_t wanted_count = 0, from = 0;
  while (from < all.size() || !tickets.empty()) {
    std::vector<HeldAttempt> held;
    for (; from < all.size() && held.size() < kOfferAtOnce; ++from) {
      held.push_back({all[from].id, all[from].chunks});
    }
    ENAMEL_RETURN_IF_ERROR(Meanwhiles());
    ENAMEL_ASSIGN_OR_RETURN(auto wanted, link_.OfferAttempts(held, std::exchange(tickets, {})));
    for (const Uuid& id : wanted.attempts) {
      // Only offered ids count: only they can be sent again.
      bool offered = std::ranges::find(held, id, &HeldAttempt::attempt) != held.end();
      if (!offered) continue;
      ENAMEL_RETURN_IF_ERROR(spool_.MarkWanted(id));
      ++wanted_count;
    }
    for (const Uuid& id : wanted.revoked) ENAMEL_RETURN_IF_ERROR(spool_.tickets().Remove(id));
  }
  return wanted_count;
}

Result<std::vector<Uuid>> AttemptSender::UnusedTickets() {
  ENAMEL_ASSIGN_OR_RETURN(auto tickets, spool_.tickets().List());
  std::vector<Uuid> out;
  for (const LockedTicket& t : tickets) {
    // If it was begun it is in the spool: its recording is evidence, and its PIN may resume it.
    bool unused = !t.handed_back() && !spool_.Get(t.attempt).ok();
    if (unused && out.size() < kOfferAtOnce) out.push_back(t.attempt);
  }
  return out;
}

Status AttemptSender::ReturnTickets() {
  ENAMEL_ASSIGN_OR_RETURN(auto tickets, spool_.tickets().List());
  for (const LockedTicket& t : tickets) {
    if (!t.handed_back()) continue;
    ENAMEL_RETURN_IF_ERROR(Meanwhiles());
    // Begun after all: its recording informs the server, which would refuse the ticket's return.
    Status told = spool_.Get(t.attempt).ok() ? Status::Ok() : link_.ReturnTicket(t.attempt);
    if (IsTransient(told)) return told;
    ENAMEL_RETURN_IF_ERROR(spool_.tickets().Remove(t.attempt));
  }
  return Status::Ok();
}

Status AttemptSender::Send(const Uuid& attempt, const std::function<bool()>& yield) {
  Status status = SendOnce(attempt, yield);
  if (status.ok() || (IsTransient(status) && !IsStopped(status))) {
    if (Status noted = spool_.MarkTried(attempt, status.message()); status.ok()) return noted;
  }
  // Of this station, not of the recording: whoever is admitted again goes on.
  if (IsTransient(status) || status.code() == Code::kUnauthenticated) return status;
  // The next try starts where the server says, not where the sending stopped.
  next_.erase(attempt);
  if (status.code() == Code::kConflict && status.field() == "seq") {
    // The server is at another chunk than it said: ask again on a new connection.
    return Status(Code::kUnavailable, status.message());
  }
  ENAMEL_RETURN_IF_ERROR(spool_.MarkRefused(attempt, status.message()));
  return status;
}

Status AttemptSender::SendOnce(const Uuid& attempt, const std::function<bool()>& yield) {
  if (!next_.contains(attempt)) {
    ENAMEL_ASSIGN_OR_RETURN(auto stored, spool_.Get(attempt));
    ENAMEL_ASSIGN_OR_RETURN(auto header, spool_.HeaderOf(attempt));
    ENAMEL_ASSIGN_OR_RETURN(auto opened, link_.OpenAttempt(header, stored.facts));
    NoteWatched(attempt, opened.watched);
    // The server's answer counts, even if it is less than before: a restored backup may lack
    // chunks.
    ENAMEL_RETURN_IF_ERROR(spool_.SetCommittedBelow(attempt, opened.next_seq));
    next_[attempt] = opened.next_seq;
  }
  Status sent = SendChunks(attempt, yield);
  // The server keeps what was read before the damage, and the connection serves the other
  // recordings.
  if (IsDamaged(sent)) {
    if (Status taken = TakeAllAcks(); !taken.ok()) sent = taken;
  }
  // One of the chunks was refused: the answers to the others are still to come, and mean nothing
  // now.
  if (!sent.ok() && waiting_ > 0) link_.Close();
  ENAMEL_RETURN_IF_ERROR(sent);
  ENAMEL_ASSIGN_OR_RETURN(auto stored, spool_.Get(attempt));
  if (!stored.seal || stored.sealed_at_server || stored.committed < stored.seal->chunks) {
    return Status::Ok();
  }
  if (held_ && held_(attempt)) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(link_.Seal(*stored.seal));
  next_.erase(attempt);
  return spool_.MarkSealedAtServer(attempt);
}

Status AttemptSender::SendChunks(const Uuid& attempt, const std::function<bool()>& yield) {
  uint32_t& next = next_.at(attempt);
  bool yielding = false;
  while (!yielding) {
    ENAMEL_ASSIGN_OR_RETURN(auto chunks, spool_.ChunksFrom(attempt, next, kWindow));
    if (chunks.empty()) break;
    for (const SpooledChunk& chunk : chunks) {
      yielding = yield && yield();
      if (yielding) break;
      while (waiting_ >= kWindow) ENAMEL_RETURN_IF_ERROR(TakeAck());
      ENAMEL_RETURN_IF_ERROR(AwaitBandwidth(chunk.bytes.size()));
      ENAMEL_RETURN_IF_ERROR(Meanwhiles());
      ENAMEL_RETURN_IF_ERROR(link_.SendChunk(chunk.bytes, remarks_ ? remarks_->shown(attempt) : 0));
      ++waiting_;
      next = chunk.seq + 1;
    }
  }
  return TakeAllAcks();
}

// Takes all, even if the spool cannot mark some of them.
Status AttemptSender::TakeAllAcks() {
  Status worst;
  while (waiting_ > 0) {
    Status taken = TakeAck();
    if (!taken.ok() && !IsDamaged(taken)) return taken;
    if (!taken.ok()) worst = taken;
  }
  return worst;
}

Status AttemptSender::AwaitBandwidth(size_t bytes) {
  while (true) {
    // In slices, so that Stop and the live view need not wait for a whole chunk's turn.
    auto wait = bandwidth_.Take(bytes, Clock::now());
    if (wait == Clock::duration{}) return Status::Ok();
    ENAMEL_RETURN_IF_ERROR(Meanwhiles());
    std::this_thread::sleep_for(std::min<Clock::duration>(wait, kSlice));
  }
}

Status AttemptSender::TakeAck() {
  while (true) {
    ENAMEL_RETURN_IF_ERROR(Meanwhiles());
    ENAMEL_ASSIGN_OR_RETURN(auto ack, link_.PollAck(kSlice));
    if (ack) {
      NoteWatched(ack->attempt, ack->watched);
      if (remarks_ != nullptr) {
        for (const protocol::Remark& remark : ack->remarks) remarks_->Arrived(ack->attempt, remark);
      }
      if (!ack->committed) continue;
      // Each mark is a write to disk, which delays a chunk being spooled.
      bool mark = --waiting_ == 0 || ++unmarked_ >= kWindow / 2;
      if (!mark) return Status::Ok();
      unmarked_ = 0;
      return spool_.MarkCommitted(ack->attempt, ack->seq);
    }
  }
}

void AttemptSender::NoteWatched(const Uuid& attempt, bool watched) {
  // Only one attempt at a time is made here, so only one is watched.
  if (watched)
    watched_ = attempt;
  else if (watched_ == attempt)
    watched_.reset();
}

}  // namespace enamel::station
