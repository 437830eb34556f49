#include "server/stations/content.h"

#include <algorithm>

namespace enamel::server::stations {

Result<bool> Content::IsContent(const Sha256& hash) {
  auto exercise = store_.exercises.ExerciseByContent(hash);
  if (exercise.ok()) return true;
  if (exercise.status().code() != Code::kNotFound) return exercise.status();
  ENAMEL_ASSIGN_OR_RETURN(auto scenes, store_.scenes.Scenes());
  ENAMEL_ASSIGN_OR_RETURN(auto profiles, store_.profiles.Profiles());
  return std::ranges::any_of(
             scenes, [&](const SceneRow& s) { return s.content == hash || s.volume == hash; }) ||
         std::ranges::any_of(profiles, [&](const ProfileRow& p) { return p.content == hash; });
}

Result<Content::Blob> Content::Get(const Sha256& hash) {
  {
    MutexLock lock(mutex_);
    auto at = held_.find(hash);
    if (at != held_.end()) {
      if (Blob blob = at->second.lock()) return blob;
    }
  }
  // A hash alone opens nothing: recordings and scores are blobs too, and no station fetches those.
  ENAMEL_ASSIGN_OR_RETURN(auto allowed, IsContent(hash));
  if (!allowed) {
    return Status(Code::kNotFound,
                  hash.Hex() + " is no exercise, scene, volume or device profile of this server",
                  "sha256");
  }
  ENAMEL_ASSIGN_OR_RETURN(auto bytes, store_.blobs.GetBlob(hash));
  auto blob = std::make_shared<const Bytes>(std::move(bytes));
  MutexLock lock(mutex_);
  // Held weakly: a volume of some MiB is in memory once while stations of a class fetch it, and not
  // afterwards.
  std::erase_if(held_, [](const auto& entry) { return entry.second.expired(); });
  held_[hash] = blob;
  return blob;
}

}  // namespace enamel::server::stations
