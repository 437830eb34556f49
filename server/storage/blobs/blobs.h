#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/sql/db.h"
#include "server/s3/s3_figures.h"
#include "server/storage/folder/disk.h"

namespace enamel::server {

// Content-addressed bytes: write-once, durable when Put returns, verified when read. Thread safety:
// any thread; several processes may share them.
class Blobs {
 public:
  virtual ~Blobs() = default;

  // The caller names the blob in a row within the age that Sweep is called with.
  virtual Result<Sha256> Put(ByteView data) = 0;
  // Errors: kNotFound; kStorage when the content no longer has its name's hash; kUnavailable when
  // it may be read later.
  virtual Result<Bytes> Get(const Sha256& hash) const = 0;
  virtual bool Has(const Sha256& hash) const = 0;

  // In the transaction that names these, for blobs deleted with an attempt (Free): they exist, and
  // stay until it ends. Errors: kUnavailable (one was removed since it was put: put it again).
  virtual Status Hold(sql::Db& db, const std::set<Sha256>& hashes) = 0;
  // What goes when its names do, in two steps. In the transaction (Isolation::kSerial) that has
  // taken names of these away, after that: those which no row names any more.
  struct Freed {
    Sha256 hash;
    int64_t generation = 0;  // of an S3 store's object (s3_blobs.h)
  };
  virtual Result<std::vector<Freed>> Free(sql::Db& db, const std::set<Sha256>& hashes) = 0;
  // When that transaction is kept: removes them; tells how many. What cannot be removed now is left
  // to Sweep.
  virtual Result<size_t> Remove(const std::vector<Freed>& freed) = 0;
  // Removes all that no row names and that was not put within the last `age`, which is at least a
  // day; tells how many.
  virtual Result<size_t> Sweep(std::chrono::seconds age) = 0;

  // What keeps blobs from being written now, for those who run the server; Ok: nothing is known to.
  virtual Status Problem() const { return Status::Ok(); }
  // Finds out, where that needs a question that nobody has asked for a while. May block for seconds.
  virtual void Look() {}
  // Of the store that is asked; none: these are files.
  virtual std::optional<s3::S3Figures> Figures() const { return {}; }
};

// Files: FOLDER/ab/ab12….  Concurrent puts share one sync.
class FolderBlobs final : public Blobs {
 public:
  // `named`: every blob that a row names now; for Remove and Sweep.
  using Named = std::function<Result<std::set<Sha256>>()>;
  FolderBlobs(std::filesystem::path folder, Disk& disk, std::function<bool()> fail_next = {},
              Named named = {})
      : folder_(std::move(folder)),
        disk_(disk),
        fail_next_(std::move(fail_next)),
        named_(std::move(named)) {}

  Result<Sha256> Put(ByteView data) override;
  Result<Bytes> Get(const Sha256& hash) const override;
  bool Has(const Sha256& hash) const override;
  Status Hold(sql::Db&, const std::set<Sha256>&) override { return Status::Ok(); }
  // All of them: Remove looks again.
  Result<std::vector<Freed>> Free(sql::Db& db, const std::set<Sha256>& hashes) override;
  Result<size_t> Remove(const std::vector<Freed>& freed) override;
  Result<size_t> Sweep(std::chrono::seconds age) override;

  // Every blob by name, in order. `others`: files that are none (an interrupted write, something
  // put there by hand). None while there is no folder. Errors: kStorage.
  struct Listing {
    std::vector<Sha256> blobs;
    std::vector<std::filesystem::path> others;
  };
  Result<Listing> List() const;
  std::filesystem::path PathOf(const Sha256& hash) const;

 private:
  // Unless it was put within the last `age`; returns whether it was removed.
  Result<bool> RemoveIfOlder(const Sha256& hash, std::chrono::seconds age);

  const std::filesystem::path folder_;
  Disk& disk_;
  const std::function<bool()> fail_next_;
  const Named named_;
  // So that no blob is removed while it is put again, and nobody relies on a folder that another
  // thread has made and not yet synced.
  Mutex mutex_;
};

}  // namespace enamel::server
