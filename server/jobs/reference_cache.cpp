#include "server/jobs/reference_cache.h"

#include "server/jobs/stored_tooth.h"

namespace enamel::server {
namespace {

Result<std::shared_ptr<const ReferenceCut>> Read(Store& store, const Uuid& attempt) {
  ENAMEL_ASSIGN_OR_RETURN(auto result, store.results.ResultOf(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto volume, CutTooth(store.blobs, result.final_volume));
  ENAMEL_ASSIGN_OR_RETURN(auto header_bytes, store.recordings.AttemptHeader(attempt));
  ENAMEL_ASSIGN_OR_RETURN(auto header, trace::DecodeHeader(header_bytes));
  ENAMEL_ASSIGN_OR_RETURN(auto seal, store.recordings.AttemptSeal(attempt));
  ENAMEL_ASSIGN_OR_RETURN(const auto recording, store.recordings.Open(attempt));

  scoring::ProcessRecorder process(header.params);
  for (;;) {
    ENAMEL_ASSIGN_OR_RETURN(const auto bytes, recording.next());
    if (!bytes) break;
    ENAMEL_ASSIGN_OR_RETURN(auto chunk, trace::DecodeChunk(*bytes));
    for (const trace::Tick& tick : chunk.ticks) process.AddRecorded(tick);
  }
  surface::Mesh surface = surface::ExtractSurface(volume);
  return std::shared_ptr<const ReferenceCut>(
      new ReferenceCut{header.volume, seal.last_chunk, result.final_volume, std::move(volume),
                       std::move(surface), std::move(process)});
}

}  // namespace

Result<std::shared_ptr<const ReferenceCut>> ReferenceCache::Get(Store& store, const Uuid& attempt) {
  {
    MutexLock lock(mutex_);
    for (const auto& [id, cut] : kept_) {
      if (id == attempt) return cut;
    }
  }
  auto cut = Read(store, attempt);
  ENAMEL_RETURN_IF_ERROR(cut.status());
  MutexLock lock(mutex_);
  kept_.emplace_front(attempt, *cut);
  if (kept_.size() > capacity_) kept_.pop_back();
  return cut;
}

std::optional<scoring::MetricSet> ReferenceCache::Metrics(const std::string& key) {
  MutexLock lock(mutex_);
  for (const auto& [known, metrics] : metrics_) {
    if (known == key) return metrics;
  }
  return std::nullopt;
}

void ReferenceCache::KeepMetrics(const std::string& key, const scoring::MetricSet& metrics) {
  MutexLock lock(mutex_);
  metrics_.emplace_front(key, metrics);
  if (metrics_.size() > kMaxMetrics) metrics_.pop_back();
}

Result<scoring::Motion> ReferenceCache::MotionIn(StoredBlobs& blobs, const Sha256& content) {
  {
    MutexLock lock(mutex_);
    if (const auto known = motions_.find(content); known != motions_.end()) return known->second;
  }
  ENAMEL_ASSIGN_OR_RETURN(const auto bytes, blobs.GetBlob(content));
  ENAMEL_ASSIGN_OR_RETURN(const auto motion, scoring::DecodeMotion(bytes));
  MutexLock lock(mutex_);
  if (motions_.emplace(content, motion).second) motions_read_.push_front(content);
  if (motions_.size() > kMaxMotions) {
    motions_.erase(motions_read_.back());
    motions_read_.pop_back();
  }
  return motion;
}

}  // namespace enamel::server
