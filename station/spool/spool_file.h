#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/sql/query.h"
#include "common/sqlite/sqlite_db.h"

namespace enamel::station {

inline constexpr char kSpoolFile[] = "spool.sqlite";
inline constexpr int32_t kSpoolMark = 0x454e7370;  // PRAGMA application_id: "ENsp"

// In order; the n-th (1-based) leads to version n of the spool. Generated from
// schemas/sql/station_spool.
const std::vector<sql::Migration>& SpoolMigrations();

// kVersion: it is no spool of this Enamel, and what to do.
Status NotOurs(const std::filesystem::path& spool);

// The cause of a failure, to tell people what to do.
using SpoolTrouble = sql::SqliteFailure::Kind;
std::string WhatToDoAbout(SpoolTrouble trouble);

// The database file of a spool: finds, creates, migrates and opens it. Its tables belong to Spool,
// SpooledTickets, SpooledLoopFacts and VerifyRecordings.
//
// Thread safety: callers of db(), Run, Fail or Exec hold mutex(). Real-time: never. Errors: those
// of Spool.
class SpoolFile {
 public:
  // For Spool::Open and Spool::OpenToRead.
  static Result<std::unique_ptr<SpoolFile>> Open(const std::filesystem::path& folder);
  static Result<std::unique_ptr<SpoolFile>> OpenToRead(const std::filesystem::path& folder);
  ~SpoolFile();
  SpoolFile(const SpoolFile&) = delete;
  SpoolFile& operator=(const SpoolFile&) = delete;

  sql::Db& db() { return *db_; }
  Mutex& mutex() ENAMEL_THREAD_SAFETY(lock_returned(mutex_)) { return mutex_; }
  const std::filesystem::path& path() const { return path_; }

  // The error of the last statement, described as failing at `doing`.
  Status Fail(const char* doing) const;
  // Runs a statement that returns no rows.
  Status Run(sql::Query& query, const char* doing);
  // A durable write that changes nothing.
  Status TestWrite();

 private:
  explicit SpoolFile(std::filesystem::path path) : path_(std::move(path)) {}
  Status OpenDb(const std::filesystem::path& file, sql::SqliteDbOptions options, const char* doing);
  Result<int> Version();
  Status CheckVersion(int version) const;
  Status CheckNotLost() const;
  Status Create();
  Status OpenCopy();
  Status BringUpToDate(int version);

  std::filesystem::path path_;
  std::filesystem::path copy_;  // folder of the copy being read; empty: the original is read
  std::unique_ptr<sql::SqliteDb> db_;
  SpoolTrouble opening_ = SpoolTrouble::kOther;  // why it could not be opened
  Mutex mutex_;
};

}  // namespace enamel::station
