#pragma once

#include <filesystem>
#include <optional>

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"

namespace enamel::station {

// Scenes, volumes, exercises and profiles on the station's disk, named by their content. A file
// that does not match its name counts as absent. Thread safety: const; files are written
// atomically.
class BlobCache {
 public:
  explicit BlobCache(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::optional<Bytes> Find(const Sha256& name) const;
  // Errors: kStorage. Requires: HashSha256(data) == name.
  Status Put(const Sha256& name, ByteView data) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace enamel::station
