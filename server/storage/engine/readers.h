#pragma once

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/storage/engine/database.h"

namespace enamel::server::sqlite {

// Read connections, opened as needed up to a number, then waited for.
// Thread safety: any thread.
class Readers {
 public:
  Readers(std::filesystem::path path, int most, std::string vfs)
      : path_(std::move(path)), most_(most), vfs_(std::move(vfs)) {}

  class Lease {
   public:
    Lease(Readers& readers, std::unique_ptr<SqliteDb> db) : readers_(readers), db_(std::move(db)) {}
    ~Lease() { readers_.Return(std::move(db_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    Db& db() { return *db_; }

   private:
    Readers& readers_;
    std::unique_ptr<SqliteDb> db_;
  };
  Result<std::unique_ptr<SqliteDb>> Take();

 private:
  void Return(std::unique_ptr<SqliteDb> db);

  const std::filesystem::path path_;
  const int most_;
  const std::string vfs_;
  std::mutex mutex_;
  std::condition_variable returned_;
  std::vector<std::unique_ptr<SqliteDb>> idle_;  // guarded by mutex_
  int open_ = 0;                                 // guarded by mutex_
};

}  // namespace enamel::server::sqlite
