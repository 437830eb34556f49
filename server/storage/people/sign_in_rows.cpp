#include "server/storage/people/sign_in_rows.h"

#include <sodium.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include "server/storage/engine/query.h"

// Failures to sign in that several servers count.
namespace enamel::server {
namespace {

// Counters are looked through for those that are over once in so many changes.
constexpr uint64_t kSweepEvery = 64;
constexpr int64_t kSweptAtOnce = 1000;

// The order in which all servers lock them.
std::vector<size_t> InOrder(const std::vector<Sha256>& keys) {
  std::vector<size_t> order(keys.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::sort(order, {}, [&](size_t i) { return keys[i].bytes; });
  return order;
}

// Whether there is a row of it.
Result<bool> ReadCounter(Db& db, const Sha256& key, const char* lock, SignInCounter& out) {
  Query q(db, std::string("SELECT failures, first_tries, last_ms, next_try_ms, until_ms FROM "
                          "sign_in_counters WHERE tenant = ?1 AND key = ?2") +
                  lock);
  out = {};
  const bool found = q.Bind(key).Next();
  ENAMEL_RETURN_IF_ERROR(q.status());
  if (found) {
    out = {static_cast<uint32_t>(q.Int(0)), static_cast<uint32_t>(q.Int(1)), q.Int(2), q.Int(3),
           q.Int(4)};
  }
  return found;
}

// A missing row cannot be locked: it is inserted first, with nothing counted.
Status LockCounter(Db& db, const Sha256& key, SignInCounter& out) {
  for (;;) {
    ENAMEL_RETURN_IF_ERROR(Insert(db, "sign_in_counters", "key", key, "failures", 0, "first_tries",
                                  0, "last_ms", 0, "next_try_ms", 0, "until_ms", 0,
                                  " ON CONFLICT DO NOTHING"));
    // Another server may have deleted it between the two.
    ENAMEL_ASSIGN_OR_RETURN(const bool locked, ReadCounter(db, key, db.RowLock(), out));
    if (locked) return Status::Ok();
  }
}

Status WriteCounter(Db& db, const Sha256& key, const SignInCounter& counter) {
  if (counter == SignInCounter{}) {
    return Query(db, "DELETE FROM sign_in_counters WHERE tenant = ?1 AND key = ?2").Bind(key).Run();
  }
  Query q(
      db,
      "UPDATE sign_in_counters SET failures = ?3, first_tries = ?4, last_ms = ?5, next_try_ms = "
      "?6, until_ms = ?7 WHERE tenant = ?1 AND key = ?2");
  return q
      .Bind(key, counter.failures, counter.first_tries, counter.last_ms, counter.next_try_ms,
            counter.until_ms)
      .Run();
}

// Those that others have locked stay for the next time.
Status Delete(Db& db, const std::string& which, int64_t value) {
  Query q(db,
          "DELETE FROM sign_in_counters WHERE tenant = ?1 AND key IN (SELECT key FROM "
          "sign_in_counters WHERE tenant = ?1 AND " +
              which + " ORDER BY until_ms LIMIT ?3" + db.RowLockOrSkip() + ")");
  return q.Bind(value, kSweptAtOnce).Run();
}

// Those with failures and those without are bounded apart, so that nobody who signs in often makes
// failures forgotten.
Status DeleteBeyondMost(Db& db, const std::string& kind) {
  Query most(db, "SELECT until_ms FROM sign_in_counters WHERE tenant = ?1 AND " + kind +
                     " ORDER BY until_ms DESC LIMIT 1 OFFSET ?2");
  const bool too_many = most.Bind(SignInRows::kMaxSignInCounters).Next();
  ENAMEL_RETURN_IF_ERROR(most.status());
  return too_many ? Delete(db, kind + " AND until_ms <= ?2", most.Int(0)) : Status::Ok();
}

Status TransactOnce(Db& db, const std::function<Status(Db&)>& work) {
  sql::Transaction transaction(db, sql::Isolation::kRowLocks);
  ENAMEL_RETURN_IF_ERROR(transaction.begun());
  // A sign-in waits for another server at most this long.
  ENAMEL_RETURN_IF_ERROR(db.Exec("SET LOCAL lock_timeout = '2s'"));
  ENAMEL_RETURN_IF_ERROR(work(db));
  return transaction.Commit();
}

}  // namespace

SignInRows::SignInRows(Transactions& rows, const trace::SecretKey& shared)
    : rows_(rows),
      // An Ed25519 secret key begins with its seed.
      secret_(DataKey(ByteView(shared).first(DataKey::kBytes)).Derive("ENSIkeys", 1)) {}

Sha256 SignInRows::Keyed(const Sha256& key) const {
  Sha256 out;
  crypto_generichash(out.bytes.data(), out.bytes.size(), key.bytes.data(), key.bytes.size(),
                     secret_.view().data(), secret_.view().size());
  return out;
}

Status SignInRows::Write(const std::function<Status(Db&)>& work) {
  constexpr int kTries = 5;
  if (!rows_.shared()) return rows_.Write(work);
  MutexLock lock(mutex_);
  if (db_ == nullptr) {
    ENAMEL_ASSIGN_OR_RETURN(db_, rows_.OpenWriter());
  }
  Status done;
  for (int i = 0; i < kTries; ++i) {
    done = TransactOnce(*db_, work);
    if (done.ok() || !db_->must_repeat()) break;
  }
  return done;
}

Status SignInRows::Sweep() {
  return Write([](Db& db) -> Status {
    ENAMEL_RETURN_IF_ERROR(Delete(db, "until_ms < ?2", NowMs()));
    ENAMEL_RETURN_IF_ERROR(DeleteBeyondMost(db, "failures > 0"));
    return DeleteBeyondMost(db, "failures = 0");
  });
}

Status SignInRows::Change(const std::vector<Sha256>& given, const SignInChange& change) {
  std::vector<Sha256> keys;
  for (const Sha256& key : given) keys.push_back(Keyed(key));
  const std::vector<size_t> order = InOrder(keys);
  // Most tries change nothing before the password check, and must cost no write.
  std::vector<SignInCounter> before(keys.size());
  const Status read = rows_.Read([&](Db& db) -> Status {
    for (size_t i : order) {
      ENAMEL_RETURN_IF_ERROR(ReadCounter(db, keys[i], "", before[i]).status());
    }
    return Status::Ok();
  });
  ENAMEL_RETURN_IF_ERROR(read);
  std::vector<SignInCounter> after = before;
  change(after);
  if (after == before) return Status::Ok();
  const Status changed = Write([&](Db& db) -> Status {
    for (size_t i : order) ENAMEL_RETURN_IF_ERROR(LockCounter(db, keys[i], before[i]));
    after = before;
    change(after);
    for (size_t i : order) {
      // Also one that was made to be locked.
      if (after[i] != before[i] || after[i] == SignInCounter{}) {
        ENAMEL_RETURN_IF_ERROR(WriteCounter(db, keys[i], after[i]));
      }
    }
    return Status::Ok();
  });
  ENAMEL_RETURN_IF_ERROR(changed);
  return changes_.fetch_add(1) % kSweepEvery == 0 ? Sweep() : Status::Ok();
}

}  // namespace enamel::server
