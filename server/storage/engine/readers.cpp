#include "server/storage/engine/readers.h"

#include <spdlog/spdlog.h>

namespace enamel::server {

Result<std::unique_ptr<Db>> Readers::Take() {
  {
    MutexLock lock(mutex_);
    // Without a bound of its own: each holder keeps a connection for one read, and callers that
    // must not wait so long use a thread that others do not need (StorePool; an HTTP request ends
    // after 60 s).
    returned_.wait(mutex_,
                   [&]() ENAMEL_REQUIRES(mutex_) { return !idle_.empty() || open_ < most_; });
    if (!idle_.empty()) {
      auto db = std::move(idle_.back());
      idle_.pop_back();
      return db;
    }
    ++open_;
  }
  auto db = open_one_();
  if (db.ok()) return db;
  {
    MutexLock lock(mutex_);
    --open_;
    returned_.notify_one();
  }
  spdlog::warn("database: {}", db.status().message());
  return Status(db.status().code(), "the database cannot be read; the log says why");
}

void Readers::Return(std::unique_ptr<Db> db) {
  MutexLock lock(mutex_);
  idle_.push_back(std::move(db));
  returned_.notify_one();
}

}  // namespace enamel::server
