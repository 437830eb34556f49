#pragma once

#include <filesystem>
#include <functional>
#include <mutex>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"

namespace enamel::server::sqlite {

// Content-addressed files: FOLDER/ab/ab12….  Write-once, durable when Put returns, verified when
// read. Thread safety: any thread (one Put at a time); several processes may share the folder.
class Blobs {
 public:
  Blobs(std::filesystem::path folder, std::function<bool()> fail_next)
      : folder_(std::move(folder)), fail_next_(std::move(fail_next)) {}

  Result<Sha256> Put(ByteView data);
  // Errors: kNotFound; kStorage when the content no longer has its name's hash.
  Result<Bytes> Get(const Sha256& hash) const;
  bool Has(const Sha256& hash) const;

 private:
  std::filesystem::path PathOf(const Sha256& hash) const;

  const std::filesystem::path folder_;
  const std::function<bool()> fail_next_;
  std::mutex mutex_;  // serialises Put: equal content shares a temporary name
};

}  // namespace enamel::server::sqlite
