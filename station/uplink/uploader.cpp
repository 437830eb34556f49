#include "station/uplink/uploader.h"

#include <algorithm>
#include <random>

namespace enamel::station {
namespace {

constexpr size_t kWindow = 16;  // chunks on the way without acknowledgement
constexpr std::chrono::milliseconds kFirstDelay{500};
constexpr std::chrono::milliseconds kLongestDelay{30'000};

std::chrono::milliseconds Delay(int failures) {
  auto delay = std::min(kLongestDelay, kFirstDelay * (1 << std::min(failures - 1, 6)));
  static thread_local std::minstd_rand random{std::random_device{}()};
  return delay - std::chrono::milliseconds(random() % static_cast<unsigned>(delay.count() / 2 + 1));
}

Status SendChunks(ServerLink& link, Spool& spool, const Uuid& attempt, uint32_t next,
                  const std::function<bool()>& keep_going) {
  size_t waiting = 0;
  auto take_ack = [&]() -> Status {
    auto ack = link.NextAck();
    if (!ack.ok()) return ack.status();
    --waiting;
    return ack->committed ? spool.MarkCommitted(attempt, ack->seq) : Status::Ok();
  };
  while (true) {
    auto chunks = spool.ChunksFrom(attempt, next, kWindow);
    if (!chunks.ok()) return chunks.status();
    if (chunks->empty()) break;
    for (const SpooledChunk& chunk : *chunks) {
      if (keep_going && !keep_going()) return Status(Code::kUnavailable, "the upload was stopped");
      if (waiting == kWindow) ENAMEL_RETURN_IF_ERROR(take_ack());
      ENAMEL_RETURN_IF_ERROR(link.SendChunk(chunk.bytes));
      ++waiting;
      next = chunk.seq + 1;
    }
  }
  while (waiting > 0) ENAMEL_RETURN_IF_ERROR(take_ack());
  return Status::Ok();
}

Status UploadOnce(ServerLink& link, Spool& spool, const Uuid& attempt,
                  const std::function<bool()>& keep_going) {
  auto header = spool.HeaderOf(attempt);
  if (!header.ok()) return header.status();
  auto next = link.OpenAttempt(*header);
  if (!next.ok()) return next.status();
  ENAMEL_RETURN_IF_ERROR(spool.SetCommittedBelow(attempt, *next));
  ENAMEL_RETURN_IF_ERROR(SendChunks(link, spool, attempt, *next, keep_going));
  auto stored = spool.Get(attempt);
  if (!stored.ok()) return stored.status();
  if (!stored->seal || stored->committed < stored->seal->chunks) return Status::Ok();
  ENAMEL_RETURN_IF_ERROR(link.Seal(*stored->seal));
  return spool.MarkSealedAtServer(attempt);
}

}  // namespace

bool IsTransient(const Status& status) {
  return status.code() == Code::kUnavailable || status.code() == Code::kStorage ||
         status.code() == Code::kInternal;
}

Status UploadAttempt(ServerLink& link, Spool& spool, const Uuid& attempt,
                     const std::function<bool()>& keep_going) {
  Status status = UploadOnce(link, spool, attempt, keep_going);
  if (!status.ok() && !IsTransient(status)) {
    ENAMEL_RETURN_IF_ERROR(spool.MarkRefused(attempt, status.message()));
  }
  return status;
}

Uploader::Uploader(Credentials credentials, Spool& spool, const Uuid& attempt)
    : credentials_(std::move(credentials)),
      spool_(spool),
      attempt_(attempt),
      thread_([this] { Run(); }) {}

Uploader::~Uploader() { Stop(); }

void Uploader::Wake() {
  std::lock_guard lock(mutex_);
  wake_ = true;
  changed_.notify_all();
}

Uploader::State Uploader::state() const {
  std::lock_guard lock(mutex_);
  return state_;
}

void Uploader::WaitUntilDone(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  auto gone_since = std::chrono::steady_clock::now();
  while (!state_.sealed && !state_.gave_up && !stop_) {
    if (state_.reachable) gone_since = std::chrono::steady_clock::now();
    if (changed_.wait_until(lock, gone_since + patience) == std::cv_status::timeout &&
        !state_.reachable) {
      return;
    }
  }
}

void Uploader::Stop() {
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
    if (link_ != nullptr) link_->Cancel();
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}

Status Uploader::Once(ServerLink& link) {
  if (!link.connected()) ENAMEL_RETURN_IF_ERROR(link.Connect(credentials_));
  {
    std::lock_guard lock(mutex_);
    state_.reachable = true;
    changed_.notify_all();
  }
  return UploadAttempt(link, spool_, attempt_, [this] {
    std::lock_guard lock(mutex_);
    return !stop_;
  });
}

void Uploader::Run() {
  ServerLink link;
  std::unique_lock lock(mutex_);
  link_ = &link;
  while (!stop_ && !state_.sealed && !state_.gave_up) {
    changed_.wait(lock, [&] { return wake_ || stop_; });
    if (stop_) break;
    wake_ = false;
    lock.unlock();
    Status status = Once(link);
    auto stored = spool_.Get(attempt_);
    lock.lock();
    if (stored.ok()) {
      state_.committed = stored->committed;
      state_.sealed = stored->complete();
    }
    state_.problem = status;
    state_.reachable = status.ok();
    state_.gave_up = !status.ok() && !IsTransient(status);
    changed_.notify_all();
    if (status.ok()) {
      failures_ = 0;
      continue;
    }
    wake_ = true;
    link.Close();
    changed_.wait_for(lock, Delay(++failures_), [&] { return stop_; });
  }
  link_ = nullptr;
}

}  // namespace enamel::station
