#pragma once

#include <sqlite3.h>

#include <atomic>

namespace enamel::station {

// A disk that refuses writes, for SQLite. Its files are real, and while `fail` is not SQLITE_OK
// every write and every new file fails with it: a full disk (SQLITE_FULL), one mounted read-only
// (SQLITE_READONLY) or a broken one (SQLITE_IOERR_WRITE). One at a time.
class FaultyDisk {
 public:
  FaultyDisk() {
    real_ = sqlite3_vfs_find(nullptr);
    ours_ = *real_;
    ours_.zName = "faulty";
    ours_.xOpen = Open;
    sqlite3_vfs_register(&ours_, 1);
  }
  ~FaultyDisk() {
    fail = SQLITE_OK;
    sqlite3_vfs_unregister(&ours_);
    sqlite3_vfs_register(real_, 1);
  }
  FaultyDisk(const FaultyDisk&) = delete;
  FaultyDisk& operator=(const FaultyDisk&) = delete;

  static inline std::atomic<int> fail{SQLITE_OK};
  static inline std::atomic<int> refused{0};  // writes

 private:
  static int Open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out) {
    int rc = real_->xOpen(real_, name, file, flags, out);
    if (rc != SQLITE_OK || file->pMethods == nullptr) return rc;
    // The database and its log have separate tables.
    for (Table& table : tables_) {
      if (table.real == nullptr) {
        table.real = file->pMethods;
        table.ours = *table.real;
        table.ours.xWrite = Write;
      }
      if (table.real != file->pMethods) continue;
      file->pMethods = &table.ours;
      break;
    }
    return rc;
  }
  static int Write(sqlite3_file* file, const void* data, int bytes, sqlite3_int64 at) {
    if (fail != SQLITE_OK) {
      ++refused;
      return fail;
    }
    for (Table& table : tables_) {
      if (file->pMethods == &table.ours) return table.real->xWrite(file, data, bytes, at);
    }
    return SQLITE_INTERNAL;
  }

  static inline sqlite3_vfs* real_ = nullptr;
  static inline sqlite3_vfs ours_{};
  struct Table {
    const sqlite3_io_methods* real;
    sqlite3_io_methods ours;
  };
  static inline Table tables_[8]{};
};

}  // namespace enamel::station
