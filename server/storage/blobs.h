#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <mutex>
#include <vector>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "server/storage/engine/disk.h"

namespace enamel::server::sqlite {

// Content-addressed files: FOLDER/ab/ab12….  Write-once, durable when Put returns, verified when
// read. Thread safety: any thread; several processes may share the folder. What is put at the same
// time is synced at the same time.
class Blobs {
 public:
  Blobs(std::filesystem::path folder, Disk& disk, std::function<bool()> fail_next = {})
      : folder_(std::move(folder)), disk_(disk), fail_next_(std::move(fail_next)) {}

  Result<Sha256> Put(ByteView data);
  // Errors: kNotFound; kStorage when the content no longer has its name's hash.
  Result<Bytes> Get(const Sha256& hash) const;
  bool Has(const Sha256& hash) const;
  // Absent: nothing to do.
  Status Remove(const Sha256& hash);
  // Unless it was put within the last `age`; tells whether it is gone.
  Result<bool> RemoveIfOlder(const Sha256& hash, std::chrono::seconds age);

  // Every blob by name, in order. `others`: files that are none (an interrupted write, something
  // put there by hand). Errors: kStorage.
  struct Listing {
    std::vector<Sha256> blobs;
    std::vector<std::filesystem::path> others;
  };
  Result<Listing> List() const;
  std::filesystem::path PathOf(const Sha256& hash) const;

 private:
  const std::filesystem::path folder_;
  Disk& disk_;
  const std::function<bool()> fail_next_;
  // Against removing what is just being put again, and against counting on a folder that another
  // thread has made and not yet synced.
  std::mutex mutex_;
};

}  // namespace enamel::server::sqlite
