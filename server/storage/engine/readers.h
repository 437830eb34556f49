#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/mutex.h"
#include "server/storage/engine/database.h"

namespace enamel::server {

// Read connections, opened as needed up to a number, then waited for.
// Thread safety: any thread.
class Readers {
 public:
  // Each holder keeps a connection for one read.
  static constexpr std::chrono::seconds kLongestWait{4};
  // `open` makes one.
  Readers(std::function<Result<std::unique_ptr<Db>>()> open, int most)
      : open_one_(std::move(open)), most_(most) {}

  class Lease {
   public:
    Lease(Readers& readers, std::unique_ptr<Db> db) : readers_(readers), db_(std::move(db)) {}
    ~Lease() { readers_.Return(std::move(db_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    Db& db() { return *db_; }

   private:
    Readers& readers_;
    std::unique_ptr<Db> db_;
  };
  // Errors: kUnavailable (all are in use for kLongestWait, or none can be opened).
  Result<std::unique_ptr<Db>> Take();

 private:
  void Return(std::unique_ptr<Db> db);

  const std::function<Result<std::unique_ptr<Db>>()> open_one_;
  const int most_;
  Mutex mutex_;
  std::condition_variable_any returned_;
  std::vector<std::unique_ptr<Db>> idle_ ENAMEL_GUARDED_BY(mutex_);
  int open_ ENAMEL_GUARDED_BY(mutex_) = 0;
};

}  // namespace enamel::server
