#pragma once

#include <sqlite3.h>

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "common/base/result.h"

namespace enamel::station {

inline constexpr char kSpoolFile[] = "spool.sqlite";

// What can be done about an error of SQLite, for people.
std::string WhatToDoAbout(int sqlite_code);

// The database file of a spool: found, made, brought to this program's version, and opened. What is
// in its tables is for Spool, SpooledTickets, SpooledLoopFacts and VerifyRecordings.
//
// Thread safety: whoever uses handle(), Fail or Exec holds mutex(): a statement's error is read
// after it, by connection. Real-time: never. Errors: those of Spool.
class SpoolFile {
 public:
  // Spool::Open's and Spool::OpenToRead's.
  static Result<std::unique_ptr<SpoolFile>> Open(const std::filesystem::path& folder);
  static Result<std::unique_ptr<SpoolFile>> OpenToRead(const std::filesystem::path& folder);
  ~SpoolFile();
  SpoolFile(const SpoolFile&) = delete;
  SpoolFile& operator=(const SpoolFile&) = delete;

  sqlite3* handle() { return handle_; }
  std::mutex& mutex() { return mutex_; }
  const std::filesystem::path& path() const { return path_; }

  // The error of the last statement, said as one of `doing`.
  Status Fail(const char* doing) const;
  Status Exec(const char* sql, const char* doing);
  // A write that changes nothing and has become durable.
  Status TestWrite();

 private:
  explicit SpoolFile(std::filesystem::path path) : path_(std::move(path)) {}
  Status UseWal();
  Result<int64_t> Version();
  Status CheckVersion(int64_t version) const;
  Status CheckNotLost() const;
  Status Create();
  Status OpenForReading(const std::string& uri, int flags);
  Status OpenCopy();
  Status BringUpToDate();

  std::filesystem::path path_;
  std::filesystem::path copy_;  // folder that it is read in; empty: where it lies
  sqlite3* handle_ = nullptr;
  std::mutex mutex_;
};

// All of a transaction or nothing: what is not committed is rolled back.
class SpoolTransaction {
 public:
  explicit SpoolTransaction(sqlite3* db) : db_(db) {
    open_ = sqlite3_exec(db_, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr) == SQLITE_OK;
  }
  ~SpoolTransaction() {
    if (open_) sqlite3_exec(db_, "ROLLBACK", nullptr, nullptr, nullptr);
  }
  SpoolTransaction(const SpoolTransaction&) = delete;
  SpoolTransaction& operator=(const SpoolTransaction&) = delete;

  bool open() const { return open_; }
  bool Commit() {
    if (sqlite3_exec(db_, "COMMIT", nullptr, nullptr, nullptr) != SQLITE_OK) return false;
    open_ = false;
    return true;
  }

 private:
  sqlite3* db_;
  bool open_ = false;
};

}  // namespace enamel::station
