#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "common/trace/trace.h"
#include "server/storage/data_key.h"
#include "server/storage/sign_in_store.h"
#include "server/storage/transactions.h"

namespace enamel::server::sqlite {

// The rows of sign_in_counters. Where several servers count, each change is a transaction of its own on a
// connection of its own: in one with others, servers would lock the same rows in any order, and what strangers
// type would hold up the writer that recordings wait for.
//
// A key becomes a BLAKE2b of it under a key that the servers of a school have in common: what is typed as a login
// may be a password. Thread safety: any thread; one change at a time.
class SignInRows {
 public:
  using OpenWriter = std::function<Result<std::unique_ptr<sql::Db>>()>;
  // `open_writer` is empty where no other server has its rows in this database: then `rows` writes.
  SignInRows(Transactions rows, OpenWriter open_writer, const trace::SecretKey& shared);

  Status Change(const std::vector<Sha256>& keys, const SignInStore::SignInChange& change);
  // Deletes what is over, and the oldest of what is more than kMostSignInCounters of a kind.
  Status Sweep();

 private:
  Sha256 Keyed(const Sha256& key) const;
  Status Write(const std::function<Status(sql::Db&)>& work);

  const Transactions rows_;
  const OpenWriter open_writer_;
  const DataKey secret_;
  std::atomic<uint64_t> changes_{0};
  std::mutex mutex_;
  std::unique_ptr<sql::Db> db_;  // guarded by mutex_; none before the first change
};

}  // namespace enamel::server::sqlite
