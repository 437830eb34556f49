#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/base/mutex.h"
#include "common/base/result.h"
#include "common/scoring/envelope.h"
#include "common/scoring/metrics.h"
#include "common/scoring/movement/motion.h"
#include "server/storage/store.h"

namespace enamel::server {

// What attempts are compared with: a reference attempt's final tooth and its recording.
struct ReferenceCut {
  Sha256 initial_volume;    // blob it was cut from
  Sha256 recording, tooth;  // its last chunk, its final volume: what a result names
  cutting::Volume final_volume;
  surface::Mesh surface;
  scoring::ProcessRecorder process;  // from the witness: its replay was verified when it was scored
};

// What other attempts are compared with, read from the store once for a cohort: the last few
// references, and motions. Scored attempts never change either, so nothing goes stale.
// Thread safety: any thread; two that miss at once both read.
class ReferenceCache {
 public:
  // `capacity`: cuts; an envelope's and one more.
  explicit ReferenceCache(size_t capacity = scoring::kMaxEnvelopeMembers + 1)
      : capacity_(capacity) {}

  // Errors: those of the store; kNotFound or kConflict when the attempt has no result.
  Result<std::shared_ptr<const ReferenceCut>> Get(Store& store, const Uuid& attempt);

  // A reference's own metrics against another one, which follow from what `key` names: the two, and
  // what they are measured by.
  std::optional<scoring::MetricSet> Metrics(const std::string& key);
  void KeepMetrics(const std::string& key, const scoring::MetricSet& metrics);

  // The motion in a blob. Errors: those of the store, of DecodeMotion.
  Result<scoring::Motion> MotionIn(StoredBlobs& blobs, const Sha256& content);

 private:
  static constexpr size_t kMaxMetrics = 64;
  // Of 3 kB each: eight exercises at once, of as many as a score looks at (score_job.cpp).
  static constexpr size_t kMaxMotions = 4000;

  const size_t capacity_;
  Mutex mutex_;
  // Newest first.
  std::deque<std::pair<Uuid, std::shared_ptr<const ReferenceCut>>> kept_ ENAMEL_GUARDED_BY(mutex_);
  std::deque<std::pair<std::string, scoring::MetricSet>> metrics_ ENAMEL_GUARDED_BY(mutex_);
  std::map<Sha256, scoring::Motion> motions_ ENAMEL_GUARDED_BY(mutex_);
  std::deque<Sha256> motions_read_ ENAMEL_GUARDED_BY(mutex_);  // newest first
};

}  // namespace enamel::server
