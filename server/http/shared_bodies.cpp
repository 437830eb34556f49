#include "server/http/shared_bodies.h"

#include <algorithm>

namespace enamel::server::http {

Result<SharedBodies::Body> SharedBodies::Get(const Sha256& name, const Read& read) {
  {
    MutexLock lock(mutex_);
    Forget();
    for (;;) {
      Slot& slot = slots_[name];
      if (Body body = slot.body.lock()) return body;
      if (!slot.reading) {
        slot.reading = true;
        break;
      }
      read_.wait(mutex_);
    }
  }
  Result<Bytes> bytes = Status(Code::kUnavailable, "there is no memory for this now; try again");
  Body body;
  // Where an allocation fails, whoever waits has to be told too.
  const auto end = [&] {
    MutexLock lock(mutex_);
    // Without a body the waiting callers find no slot, and each reads the bytes itself.
    if (body == nullptr) {
      slots_.erase(name);
    } else {
      Slot& slot = slots_.at(name);
      slot.body = body;
      slot.reading = false;
    }
    read_.notify_all();
  };
  try {
    bytes = read();
    if (bytes.ok()) body = std::make_shared<const std::string>(AsText(*bytes));
  } catch (...) {
    body = nullptr;
    end();
    throw;
  }
  end();
  if (body == nullptr) return bytes.status();
  return body;
}

Result<SharedBodies::Body> SharedBodies::Made(const Sha256& name, const Read& make) {
  Result<Body> body = Get(name, [&] { return MakeInTurn(make); });
  if (body.ok()) {
    MutexLock lock(mutex_);
    Keep(name, *body);
  }
  return body;
}

Result<Bytes> SharedBodies::MakeInTurn(const Read& make) {
  {
    MutexLock lock(mutex_);
    if (!finished_.wait_for(mutex_, patience_,
                            [&]() ENAMEL_REQUIRES(mutex_) { return making_ < kMaxMade; })) {
      return Status(Code::kUnavailable, "others are being made first; try again in a few seconds");
    }
    ++making_;
  }
  const auto end = [this] {
    MutexLock lock(mutex_);
    --making_;
    finished_.notify_one();
  };
  try {
    Result<Bytes> bytes = make();
    end();
    return bytes;
  } catch (...) {
    end();
    throw;
  }
}

void SharedBodies::Keep(const Sha256& name, const Body& body) {
  const auto now = std::chrono::steady_clock::now();
  const auto at = std::ranges::find(kept_, name, &Kept::name);
  if (at != kept_.end()) {
    at->used = now;
    kept_.splice(kept_.begin(), kept_, at);
    return;
  }
  kept_.push_front({name, body, now});
  kept_bytes_ += body->size();
  Forget();
}

void SharedBodies::Forget() {
  const auto old = std::chrono::steady_clock::now() - kFor;
  while (!kept_.empty() && (kept_bytes_ > kKeptBytes || kept_.back().used < old)) {
    kept_bytes_ -= kept_.back().body->size();
    kept_.pop_back();
  }
  // Most bodies die with the last answer that sends them, and leave their slot.
  constexpr size_t kMany = 1000;
  if (slots_.size() < kMany) return;
  std::erase_if(slots_,
                [](const auto& one) { return !one.second.reading && one.second.body.expired(); });
}

}  // namespace enamel::server::http
