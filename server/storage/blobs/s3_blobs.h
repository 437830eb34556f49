#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/base/mutex.h"
#include "server/s3/s3_client.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/blobs/s3_trouble.h"
#include "server/storage/engine/transactions.h"

namespace enamel::server {

// Blobs as objects of an S3 store that several servers share. The object of a blob is
//   PREFIX<sha256>-<generation, 16 hexadecimal digits>
// The table `blobs` says which generation counts (schemas/sql/0001_initial.sql). Any S3 store will
// do: this needs no conditional PUT, and of lists only that an object appears in one some day. An
// object is written once and never replaced.
//
// Why no server deletes a blob that another server names, or is about to name:
// * Put uploads an object of a new generation first and then adds its row. If a row exists, it
//   writes `put_ms` into it instead and uploads nothing.
// * A deletion removes the row, in one serial transaction with the check that nothing names the
//   blob. The object is deleted after that transaction commits. It has the row's generation: never
//   one that a Put uploads meanwhile.
// * Put and Hold write the row. The database repeats a serial transaction that deletes a row
//   written since it began, and the repetition sees the name, or `put_ms`. The other way round, Put
//   and Hold wait for it and find no row: Put uploads another generation, Hold refuses the name,
//   and the caller puts the blob again. So the order does not matter, and this holds for
//   Isolation::kRowLocks too.
// * Blobs that are deleted at once with an attempt (Free) are named with Hold. Sweep deletes all
//   others, a day after the last Put: a name follows its Put within minutes, or never.
// * A crash between upload and row, or between row and deletion, leaves an object without a row.
//   Sweep removes it a day after its upload. No row is added for an upload that began an hour ago
//   (kClaimWithin). Clocks of servers and store may differ by hours.
//
// Failures of the store are reported as S3Trouble says. Put finds a row whose object is lost, and
// uploads the bytes again.
//
// Thread safety: any thread. Put, Get and Remove wait for the store, at most about two of its calls
// (S3Limits).
class S3Blobs final : public Blobs {
 public:
  static constexpr std::chrono::hours kClaimWithin{1};
  static constexpr std::chrono::hours kOrphanAge{24};
  // How often the store is listed for objects without a row.
  static constexpr std::chrono::hours kListEvery{24};

  // `now_ms`: the server's clock, milliseconds since 1970; for tests.
  S3Blobs(std::unique_ptr<s3::S3Client> client, std::string prefix, Transactions& rows,
          std::function<int64_t()> now_ms = {});

  Result<Sha256> Put(ByteView data) override;
  Result<Bytes> Get(const Sha256& hash) const override;
  // By its row alone.
  bool Has(const Sha256& hash) const override;
  Status Hold(sql::Db& db, const std::set<Sha256>& hashes) override;
  Result<std::vector<Freed>> Free(sql::Db& db, const std::set<Sha256>& hashes) override;
  Result<size_t> Remove(const std::vector<Freed>& freed) override;
  Result<size_t> Sweep(std::chrono::seconds age) override;
  Status Problem() const override;
  void Look() override;
  std::optional<s3::S3Figures> Figures() const override { return client_->figures(); }

  std::string KeyOf(const Sha256& hash, int64_t generation) const;

 private:
  // The blob of a key; false: the key is none of ours.
  bool ReadKey(const std::string& key, Freed& out) const;
  Result<size_t> SweepRows(std::chrono::seconds age);
  Result<size_t> SweepOrphans();

  const std::unique_ptr<s3::S3Client> client_;
  const std::string prefix_;
  Transactions& rows_;
  const std::function<int64_t()> now_ms_;
  mutable S3Trouble trouble_;
  Mutex mutex_;
  int64_t listed_ms_ ENAMEL_GUARDED_BY(mutex_) = 0;
};

}  // namespace enamel::server
