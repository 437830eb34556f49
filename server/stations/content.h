#pragma once

#include <map>
#include <memory>

#include "common/base/bytes.h"
#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "server/storage/store.h"

namespace enamel::server::stations {

// Documents and volumes that stations may fetch: exercises of any version, scenes, their volumes,
// device profiles; never recordings or scores. While any session holds a blob, others share it:
// forty stations that fetch one volume at once cost one copy. Thread safety: any thread. Blocks
// (store).
class Content {
 public:
  using Blob = std::shared_ptr<const Bytes>;

  explicit Content(Store& store) : store_(store) {}
  // Errors: kNotFound also for stored blobs that are no content.
  Result<Blob> Get(const Sha256& hash);

 private:
  Result<bool> IsContent(const Sha256& hash);

  Store& store_;
  Mutex mutex_;
  std::map<Sha256, std::weak_ptr<const Bytes>> held_ ENAMEL_GUARDED_BY(mutex_);
};

}  // namespace enamel::server::stations
