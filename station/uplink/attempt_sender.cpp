#include "station/uplink/attempt_sender.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "common/protocol/messages.h"

namespace enamel::station {
namespace {

// Half of what the server takes in one message, so that attempts and tickets fit beside each other.
constexpr size_t kOfferAtOnce = 512;
using Clock = std::chrono::steady_clock;

}  // namespace

// A server whose disk is full (kStorage) or that failed in itself (kInternal) can be mended without
// this station; whatever else it answers it will answer again.
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
  // What the server refused is not asked again and again: ClearRefusal makes it wait once more.
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
    auto wanted = link_.OfferAttempts(held, std::exchange(tickets, {}));
    // Older than the question: it was never restored with a program that could have asked.
    if (wanted.status().code() == Code::kVersion) return size_t{0};
    if (!wanted.ok()) return wanted.status();
    for (const Uuid& id : wanted->attempts) {
      // Not what it says on its own: only what was offered can be sent again.
      bool offered = std::ranges::find(held, id, &HeldAttempt::attempt) != held.end();
      if (!offered) continue;
      ENAMEL_RETURN_IF_ERROR(spool_.MarkWanted(id));
      ++wanted_count;
    }
    for (const Uuid& id : wanted->revoked) ENAMEL_RETURN_IF_ERROR(spool_.tickets().Remove(id));
  }
  return wanted_count;
}

Result<std::vector<Uuid>> AttemptSender::UnusedTickets() {
  ENAMEL_ASSIGN_OR_RETURN(auto tickets, spool_.tickets().List());
  std::vector<Uuid> out;
  for (const LockedTicket& t : tickets) {
    // One that was begun is in the spool: its recording is evidence, and its PIN may resume it.
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
    // Begun after all: its recording tells the server, and returning the ticket would be refused.
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
  if (IsTransient(status)) return status;
  // The next try begins with what the server says it has, not with what was sent.
  next_.erase(attempt);
  if (status.code() == Code::kConflict && status.field() == "seq") {
    // The server stands elsewhere than it said: ask again on a new connection.
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
    // The server's word counts, also where it is less than it said before: a restored backup
    // forgets.
    ENAMEL_RETURN_IF_ERROR(spool_.SetCommittedBelow(attempt, opened.next_seq));
    next_[attempt] = opened.next_seq;
  }
  Status sent = SendChunks(attempt, yield);
  // What was read before the damage is the server's to keep, and the link the others' to use.
  if (IsDamaged(sent)) {
    if (Status taken = TakeAllAcks(); !taken.ok()) sent = taken;
  }
  // What was refused is one of these: the others' answers are still to come, and mean nothing now.
  if (!sent.ok() && waiting_ > 0) link_.Close();
  ENAMEL_RETURN_IF_ERROR(sent);
  ENAMEL_ASSIGN_OR_RETURN(auto stored, spool_.Get(attempt));
  if (!stored.seal || stored.sealed_at_server || stored.committed < stored.seal->chunks) {
    return Status::Ok();
  }
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

// All, also where the spool cannot mark some of them.
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
    // In slices, so that Stop and the live view need not wait until a whole chunk may go.
    auto wait = bandwidth_.Take(bytes, Clock::now());
    if (wait == Clock::duration{}) return Status::Ok();
    ENAMEL_RETURN_IF_ERROR(Meanwhiles());
    std::this_thread::sleep_for(std::min<Clock::duration>(wait, kSlice));
  }
}

Status AttemptSender::TakeAck() {
  // A connection that is up and silent is no use: TCP alone would keep it for many minutes.
  const auto deadline = Clock::now() + ServerLink::kTimeout;
  while (true) {
    ENAMEL_RETURN_IF_ERROR(Meanwhiles());
    ENAMEL_ASSIGN_OR_RETURN(auto ack, link_.PollAck(kSlice));
    if (ack) {
      NoteWatched(ack->attempt, ack->watched);
      if (remarks_ != nullptr) {
        for (const protocol::Remark& remark : ack->remarks) remarks_->Arrived(ack->attempt, remark);
      }
      if (!ack->committed) continue;
      // Each mark is a write to disk that a chunk being spooled would wait for.
      bool mark = --waiting_ == 0 || ++unmarked_ >= kWindow / 2;
      if (!mark) return Status::Ok();
      unmarked_ = 0;
      return spool_.MarkCommitted(ack->attempt, ack->seq);
    }
    if (Clock::now() > deadline) {
      link_.Close();
      return Status(Code::kUnavailable, "the server does not acknowledge what was sent to it");
    }
  }
}

void AttemptSender::NoteWatched(const Uuid& attempt, bool watched) {
  // One at a time is made here, so one at a time is watched.
  if (watched)
    watched_ = attempt;
  else if (watched_ == attempt)
    watched_.reset();
}

}  // namespace enamel::station
