#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "common/base/mutex.h"
#include "common/trace/trace.h"
#include "server/storage/engine/transactions.h"
#include "server/storage/keys/data_key.h"
#include "server/training/types.h"

namespace enamel::server {

// The counts under one key. Initially zero.
struct SignInCounter {
  uint32_t failures = 0;
  uint32_t first_tries = 0;
  UnixMs last_ms = 0;
  UnixMs next_try_ms = 0;
  UnixMs until_ms = 0;  // forgotten then
  auto operator<=>(const SignInCounter&) const = default;
};

// Failed sign-ins that the servers of a school count together; the rules are auth::Throttle's. A
// lone server (Transactions::shared) counts in its own memory.
//
// With several servers, each change is a transaction of its own on a connection of its own:
// combined with others, servers would lock the same rows in any order, and strangers' input would
// delay the writer that recordings wait for.
//
// Stores a BLAKE2b of each key, under a key that the servers of a school share: text typed as a
// login may be a password. Thread safety: any thread; one change at a time.
class SignInRows {
 public:
  SignInRows(Transactions& rows, const trace::SecretKey& shared);

  // Passes the counters of these distinct keys to `change` and stores its result, without another
  // change in between. `change` may be called again with newer ones. Unchanged counters cost no
  // write. At most kMaxSignInCounters with failures are kept, and as many without: those that
  // expire first are dropped first.
  static constexpr int64_t kMaxSignInCounters = 100'000;
  using SignInChange = std::function<void(std::vector<SignInCounter>&)>;
  Status Change(const std::vector<Sha256>& keys, const SignInChange& change);
  // Deletes expired counters, and the oldest of a kind that has more than kMaxSignInCounters.
  Status Sweep();

 private:
  Sha256 Keyed(const Sha256& key) const;
  Status Write(const std::function<Status(sql::Db&)>& work);

  Transactions& rows_;
  const DataKey secret_;
  std::atomic<uint64_t> changes_{0};
  Mutex mutex_;
  std::unique_ptr<sql::Db> db_ ENAMEL_GUARDED_BY(mutex_);  // none before the first change
};

}  // namespace enamel::server
