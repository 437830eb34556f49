#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/base/mutex.h"
#include "common/s3/s3_client.h"
#include "server/storage/blobs/blobs.h"
#include "server/storage/blobs/s3_trouble.h"
#include "server/storage/engine/transactions.h"

namespace enamel::server {

// Blobs as objects of an S3 store that several servers share. The object of a blob is
//   PREFIX<sha256>-<generation, 16 hexadecimal digits>
// and the table `blobs` says which generation counts (schemas/sql/0001_initial.sql). Of S3 no more is
// asked than every store does: no conditional PUT, nothing of lists but that an object is in one some
// day. An object is written once and never replaced.
//
// Why no server deletes what another names, or is about to name:
// * Put uploads an object of a new generation first and adds its row then; when a row is there, it
//   writes `put_ms` into it instead and uploads nothing.
// * Whoever deletes a blob deletes its row, in one serial transaction with the look that nothing
//   names it; the object goes after that transaction is kept. It is of the generation that the row
//   had: never one that a Put uploads meanwhile.
// * Put and Hold write the row. A serial transaction that deletes a row which was written since it
//   began is repeated by the database, and then sees the name, or `put_ms`. The other way round,
//   Put and Hold wait for it and find no row: Put uploads another generation, Hold refuses the
//   name, and whoever wanted it puts the blob again. So it does not matter in which order they
//   come, and it holds for Isolation::kRowLocks too.
// * What goes with an attempt, at once (Free), is named with Hold. All else goes by Sweep alone,
//   when the last Put is a day ago: a name follows its Put within minutes, or never.
// * An object without a row is what a crash between upload and row left, or between row and
//   deleting. Sweep removes it a day after it was uploaded; a row is not added any more for an
//   upload that began an hour ago (kClaimWithin). Clocks of servers and store may differ by hours.
//
// What fails of the store is told as S3Trouble does. A row whose object is lost is found by Put,
// which uploads the bytes again.
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
  Status Hold(sql::Db& db, std::initializer_list<Sha256> hashes) override;
  Result<std::vector<Freed>> Free(sql::Db& db, const std::set<Sha256>& hashes) override;
  Result<size_t> Remove(const std::vector<Freed>& freed) override;
  Result<size_t> Sweep(std::chrono::seconds age) override;
  Status Problem() const override;

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
