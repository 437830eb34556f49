#include "server/jobs/reference_cache.h"

#include "common/scene/volume_blob.h"

namespace enamel::server {
namespace {

Result<std::shared_ptr<const ReferenceCut>> Read(Store& store, const Uuid& attempt) {
  auto result = store.ResultOf(attempt);
  if (!result.ok()) return result.status();
  auto blob = store.GetBlob(result->final_volume);
  if (!blob.ok()) return blob.status();
  auto volume = scene::DecodeVolume(*blob);
  if (!volume.ok()) return volume.status();
  auto header_bytes = store.AttemptHeader(attempt);
  if (!header_bytes.ok()) return header_bytes.status();
  auto header = trace::DecodeHeader(*header_bytes);
  if (!header.ok()) return header.status();
  auto chunks = store.AttemptChunks(attempt);
  if (!chunks.ok()) return chunks.status();

  scoring::ProcessRecorder process(header->params);
  for (const Bytes& bytes : *chunks) {
    auto chunk = trace::DecodeChunk(bytes);
    if (!chunk.ok()) return chunk.status();
    for (const trace::Tick& tick : chunk->ticks) process.AddRecorded(tick);
  }
  surface::Mesh surface = surface::ExtractSurface(*volume);
  return std::shared_ptr<const ReferenceCut>(new ReferenceCut{
      header->volume, std::move(volume).value(), std::move(surface), std::move(process)});
}

}  // namespace

Result<std::shared_ptr<const ReferenceCut>> ReferenceCache::Get(Store& store, const Uuid& attempt) {
  {
    std::lock_guard lock(mutex_);
    for (const auto& [id, cut] : kept_) {
      if (id == attempt) return cut;
    }
  }
  auto cut = Read(store, attempt);
  if (!cut.ok()) return cut;
  std::lock_guard lock(mutex_);
  kept_.emplace_front(attempt, *cut);
  if (kept_.size() > capacity_) kept_.pop_back();
  return cut;
}

}  // namespace enamel::server
