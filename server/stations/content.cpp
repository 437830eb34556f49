#include "server/stations/content.h"

#include <algorithm>

namespace enamel::server::stations {

Result<bool> Content::IsContent(const Sha256& hash) {
  auto exercise = store_.ExerciseByContent(hash);
  if (exercise.ok()) return true;
  if (exercise.status().code() != Code::kNotFound) return exercise.status();
  auto scenes = store_.Scenes();
  if (!scenes.ok()) return scenes.status();
  auto profiles = store_.Profiles();
  if (!profiles.ok()) return profiles.status();
  return std::ranges::any_of(
             *scenes, [&](const SceneRow& s) { return s.content == hash || s.volume == hash; }) ||
         std::ranges::any_of(*profiles, [&](const ProfileRow& p) { return p.content == hash; });
}

Result<Content::Blob> Content::Get(const Sha256& hash) {
  {
    std::lock_guard lock(mutex_);
    auto at = held_.find(hash);
    if (at != held_.end()) {
      if (Blob blob = at->second.lock()) return blob;
    }
  }
  auto allowed = IsContent(hash);
  if (!allowed.ok()) return allowed.status();
  if (!*allowed) {
    return Status(Code::kNotFound,
                  hash.Hex() + " is no exercise, scene, volume or device profile of this server",
                  "sha256");
  }
  auto bytes = store_.GetBlob(hash);
  if (!bytes.ok()) return bytes.status();
  auto blob = std::make_shared<const Bytes>(std::move(bytes).value());
  std::lock_guard lock(mutex_);
  std::erase_if(held_, [](const auto& entry) { return entry.second.expired(); });
  held_[hash] = blob;
  return blob;
}

}  // namespace enamel::server::stations
