#include "server/storage/engine/readers.h"

#include "server/storage/engine/database_log.h"

namespace enamel::server {

Result<std::unique_ptr<Db>> Readers::Take() {
  {
    MutexLock lock(mutex_);
    const auto there = [&]() ENAMEL_REQUIRES(mutex_) { return !idle_.empty() || open_ < most_; };
    if (!returned_.wait_for(mutex_, kLongestWait, there)) {
      return Status(Code::kUnavailable, "the database is busy; try again in a few seconds");
    }
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
  WarnOfDatabase(db.status().message());
  return Status(db.status().code(), "the database cannot be read; the log says why");
}

void Readers::Return(std::unique_ptr<Db> db) {
  MutexLock lock(mutex_);
  idle_.push_back(std::move(db));
  returned_.notify_one();
}

}  // namespace enamel::server
