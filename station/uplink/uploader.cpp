#include "station/uplink/uploader.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "station/uplink/policy_file.h"

namespace enamel::station {
namespace {

using Clock = std::chrono::steady_clock;

// Size of a LiveState on the wire, with frame and TLS record.
constexpr size_t kLiveBytes = 100;

}  // namespace

Uploader::Uploader(Credentials credentials, Spool& spool, const UploaderOptions& options)
    : credentials_(std::move(credentials)),
      spool_(spool),
      bandwidth_(options.bytes_per_s),
      refused_backoff_(options.refused_first, Backoff::kRefusedLongest),
      retention_(options.retention),
      prune_every_(options.prune_every),
      offer_every_(options.offer_every),
      thread_([this] { Run(); }) {}

Uploader::~Uploader() { Stop(); }

void Uploader::Prefer(const Uuid& attempt, std::shared_ptr<LiveMailbox> live) {
  remarks_.Begin(attempt);
  MutexLock lock(mutex_);
  preferred_ = attempt;
  live_ = std::move(live);
  // A resumed attempt may have been opened on this connection, and must be opened again: reopen_.
  reopen_ = wake_ = retry_ = true;
  changed_.notify_all();
}

void Uploader::Wake() {
  MutexLock lock(mutex_);
  wake_ = look_for_tickets_ = true;
  changed_.notify_all();
}

void Uploader::Retry() {
  MutexLock lock(mutex_);
  retry_ = true;
  changed_.notify_all();
}

Uploader::State Uploader::state(const Uuid& attempt) const {
  MutexLock lock(mutex_);
  auto at = states_.find(attempt);
  State out = at == states_.end() ? State{} : at->second;
  out.reachable = about_link_.reachable;
  out.gave_up = out.gave_up || about_link_.refused;
  if (out.problem.ok()) out.problem = about_link_.problem;
  return out;
}

Uploader::Link Uploader::link() const {
  MutexLock lock(mutex_);
  return about_link_;
}

void Uploader::HoldSeal(const Uuid& attempt) {
  MutexLock lock(mutex_);
  held_.insert(attempt);
}

void Uploader::ReleaseSeal(const Uuid& attempt) {
  MutexLock lock(mutex_);
  if (held_.erase(attempt) == 0) return;
  wake_ = true;
  changed_.notify_all();
}

bool Uploader::IsHeld(const Uuid& attempt) const {
  MutexLock lock(mutex_);
  return held_.contains(attempt);
}

void Uploader::WaitUntilDone(const Uuid& attempt, std::chrono::milliseconds patience) {
  MutexLock lock(mutex_);
  auto gone_since = Clock::now();
  while (!stop_ && !about_link_.refused) {
    const State& state = states_[attempt];
    if (state.sealed || state.gave_up) return;
    // Patience is for a server that is away; a reachable one may take as long as it needs.
    if (about_link_.reachable) gone_since = Clock::now();
    if (changed_.wait_until(mutex_, gone_since + patience) == std::cv_status::timeout &&
        !about_link_.reachable) {
      return;
    }
  }
}

void Uploader::Stop() {
  {
    MutexLock lock(mutex_);
    stop_ = true;
    // The thread may be waiting for the server for seconds: Cancel ends that wait at once.
    link_.Cancel();
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

bool Uploader::stopping() const {
  MutexLock lock(mutex_);
  return stop_;
}

void Uploader::Run() {
  PruneWhenDue();
  MutexLock lock(mutex_);
  while (!stop_) {
    mutex_.unlock();
    PruneWhenDue();
    Status status = RunConnection();
    link_.Close();
    Say(status);
    // An unreadable spool gives no information on the server, and must not be written to.
    if (!IsStopped(status) && !IsDamaged(status)) (void)spool_.MarkAllTried(status.message());
    mutex_.lock();
    about_link_.reachable = false;
    about_link_.problem = status;
    about_link_.refused = !IsTransient(status);
    retry_ = false;
    changed_.notify_all();
    // A server that is away is tried again soon. One that refuses is tried seldom: only a person
    // changes that.
    Backoff& backoff = about_link_.refused ? refused_backoff_ : backoff_;
    changed_.wait_for(mutex_, backoff.Next(),
                      [&]() ENAMEL_REQUIRES(mutex_) { return stop_ || retry_; });
    if (retry_) about_link_.refused = false;
  }
}

// Logs each change once.
void Uploader::Say(const Status& status) {
  if (stopping() || said_ == status.message()) return;
  said_ = status.message();
  if (status.ok())
    spdlog::info("the server {} is reached", credentials_.server.Text());
  else if (IsDamaged(status))
    spdlog::error("the recordings that wait here cannot be sent: {}", said_);
  else if (IsTransient(status))
    spdlog::warn("the server is away, recordings are kept here: {}", said_);
  else
    spdlog::error("the server does not take this station, recordings are kept here: {}", said_);
}

void Uploader::PruneWhenDue() {
  auto now = Clock::now();
  if (!retention_ || now < prune_due_) return;
  prune_due_ = now + prune_every_;
  auto pruned = spool_.Prune(*retention_);
  if (!pruned.ok()) return spdlog::error("{}", pruned.status().message());
  if (std::string text = PrunedText(*pruned, *retention_); !text.empty()) spdlog::warn("{}", text);
}

// Until the connection breaks or Stop; never ok.
Status Uploader::RunConnection() {
  ENAMEL_RETURN_IF_ERROR(link_.Connect(credentials_));
  KeepPolicy(spool_.file().parent_path(), link_.policy());
  // Reached, so an earlier refusal is over. backoff_ is reset only after an answered request, or a
  // server that accepts and drops would be asked without end.
  refused_backoff_.Reset();
  Say(Status::Ok());
  // Meanwhile uses the sender that calls it, so this is set once the sender exists.
  AttemptSender* self = nullptr;
  AttemptSender sender(
      link_, spool_, bandwidth_, [&] { return Meanwhile(*self); }, &remarks_,
      [this](const Uuid& attempt) { return IsHeld(attempt); });
  self = &sender;
  {
    MutexLock lock(mutex_);
    about_link_.reachable = true;
    about_link_.refused = false;
    about_link_.problem = Status::Ok();
    changed_.notify_all();
  }
  ENAMEL_RETURN_IF_ERROR(sender.Offer().status());
  backoff_.Reset();
  offer_due_ = Clock::now() + offer_every_;
  while (true) {
    if (Clock::now() >= offer_due_) {
      ENAMEL_RETURN_IF_ERROR(sender.Offer().status());
      offer_due_ = Clock::now() + offer_every_;
    }
    {
      MutexLock lock(mutex_);
      look_for_tickets_ = false;
    }
    ENAMEL_RETURN_IF_ERROR(sender.ReturnTickets());
    ENAMEL_RETURN_IF_ERROR(SendWaiting(sender));
    ENAMEL_RETURN_IF_ERROR(AwaitWork(sender));
  }
}

Status Uploader::SendWaiting(AttemptSender& sender) {
  awaited_due_.reset();
  std::set<Uuid> brought;
  while (auto attempt = NextWaiting(brought)) {
    bool preferred = false, yielded = false;
    {
      MutexLock lock(mutex_);
      preferred = attempt == preferred_;
      if (preferred && std::exchange(reopen_, false)) sender.Reopen(*attempt);
    }
    Status status = sender.Send(*attempt, [&] { return yielded = !preferred && PreferredWaits(); });
    Note(*attempt, status);
    // One recording's reason to wait neither delays the others nor ends the connection.
    if (IsOfOneRecording(status)) {
      awaited_due_ = Clock::now() + kAwaitedEvery;
    } else if (IsTransient(status) || status.code() == Code::kUnauthenticated) {
      return status;
    }
    // A recording that yielded is not done: it comes again in this round.
    if (!yielded) brought.insert(*attempt);
    if (!link_.connected()) return Status(Code::kUnavailable, "the connection was lost");
    ping_due_ = Clock::now() + kPingEvery;
  }
  return Status::Ok();
}

// The preferred attempt if it waits, else the oldest that does; none of `brought`, unless there is
// new data.
std::optional<Uuid> Uploader::NextWaiting(std::set<Uuid>& brought) {
  {
    MutexLock lock(mutex_);
    if (std::exchange(wake_, false)) brought.clear();
  }
  auto waiting = WaitingAttempts(spool_);
  // An unreadable spool has nothing to send now; Note and Say report it.
  if (!waiting.ok()) return std::nullopt;
  std::erase_if(*waiting, [&](const SpooledAttempt& a) { return brought.contains(a.id); });
  if (waiting->empty()) return std::nullopt;
  MutexLock lock(mutex_);
  for (const SpooledAttempt& a : *waiting) {
    if (a.id == preferred_) return a.id;
  }
  return waiting->front().id;
}

// The attempt being made goes first, so that an instructor sees it live; older recordings yield at
// their next chunk.
bool Uploader::PreferredWaits() {
  MutexLock lock(mutex_);
  return preferred_ && wake_;
}

void Uploader::Note(const Uuid& attempt, const Status& status) {
  auto stored = spool_.Get(attempt);
  MutexLock lock(mutex_);
  State& state = states_[attempt];
  const State before = state;
  if (stored.ok()) {
    state.committed = stored->committed;
    state.sealed = stored->complete();
  }
  state.problem = status;
  // Ends waiting for this one: damage stays until a person salvages it.
  state.gave_up = !status.ok() && (!IsTransient(status) || IsDamaged(status));
  const bool news = before.problem.message() != status.message();
  if (state.sealed && !before.sealed) {
    spdlog::info("attempt {} is on the server, all {} chunks of it", attempt.Text(),
                 state.committed);
  } else if (IsDamaged(status) && news) {
    spdlog::error("attempt {} cannot be sent whole, others are still sent: {}", attempt.Text(),
                  status.message());
  } else if (state.gave_up && news) {
    spdlog::error("the server refuses attempt {}, it is kept here: {}", attempt.Text(),
                  status.message());
  } else if (IsAwaited(status) && news) {
    spdlog::warn("attempt {} has to wait: {}", attempt.Text(), status.message());
  }
  changed_.notify_all();
}

Status Uploader::Meanwhile(const AttemptSender& sender) {
  if (stopping()) return Status(Code::kUnavailable, "the upload was stopped", net::kCancelled);
  SendLive(sender);
  return Status::Ok();
}

void Uploader::SendLive(const AttemptSender& sender) {
  auto now = Clock::now();
  if (now < live_due_) return;
  std::shared_ptr<LiveMailbox> live;
  Uuid attempt;
  {
    MutexLock lock(mutex_);
    if (!preferred_ || !live_) return;
    live = live_;
    attempt = *preferred_;
  }
  if (!sender.watched(attempt)) return;
  auto point = live->Take();
  if (!point) return;
  // From its due time, so that the rate holds; without a burst after a pause.
  live_due_ = std::max(live_due_ + kLiveEvery, now - kLiveEvery);
  // A live point is only worth sending now: it never takes a chunk's place, and is dropped, not
  // kept.
  bool sent = sender.at_ease() && bandwidth_.TakeSpare(kLiveBytes, now) &&
              link_.SendLive(attempt, *point).ok();
  MutexLock lock(mutex_);
  ++(sent ? about_link_.live_sent : about_link_.live_dropped);
}

Status Uploader::Ping() {
  std::optional<Uuid> attempt;
  {
    MutexLock lock(mutex_);
    attempt = preferred_;
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto remarks,
                          link_.Ping(attempt, attempt ? remarks_.shown(*attempt) : 0));
  // A server has none for nobody's attempt.
  if (!attempt) return Status::Ok();
  for (const protocol::Remark& remark : remarks) remarks_.Arrived(*attempt, remark);
  return Status::Ok();
}

// Waits for new data, keeping the connection and the live view alive.
Status Uploader::AwaitWork(AttemptSender& sender) {
  while (true) {
    ENAMEL_RETURN_IF_ERROR(Meanwhile(sender));
    PruneWhenDue();
    auto now = Clock::now();
    if (now >= ping_due_) {
      ENAMEL_RETURN_IF_ERROR(Ping());
      ping_due_ = now + kPingEvery;
    }
    MutexLock lock(mutex_);
    bool watched = preferred_ && live_ && sender.watched(*preferred_);
    // A mailbox wakes no thread, because the tick must not; so it is polled at four times its rate.
    auto until = watched ? std::min<Clock::time_point>(ping_due_, now + kLiveEvery / 4) : ping_due_;
    if (changed_.wait_until(mutex_, std::min(until, offer_due_), [&]() ENAMEL_REQUIRES(mutex_) {
          return wake_ || look_for_tickets_ || stop_;
        }))
      return Status::Ok();
    if (awaited_due_ && Clock::now() >= *awaited_due_) return Status::Ok();
    if (Clock::now() >= offer_due_) return Status::Ok();
  }
}

}  // namespace enamel::station
