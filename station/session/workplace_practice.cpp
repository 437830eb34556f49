// Practice without the server: what the cache has, and nobody's attempt.
#include <utility>

#include "common/scene/json/json.h"
#include "station/session/practice_list.h"
#include "station/session/workplace.h"

namespace enamel::station {
namespace {

// Whether the cache has the scene of this hash and its volume.
bool HasScene(const BlobCache& cache, const Sha256& name) {
  const auto text = cache.Find(name);
  if (!text) return false;
  const auto scene = scene::SceneFromJson(AsText(*text));
  return scene.ok() && cache.Find(scene->volume).has_value();
}

}  // namespace

bool Workplace::RemembersPractice() const { return !LoadPracticeList(data_).exercises.empty(); }

Catalogue Workplace::Practices() const {
  const PracticeList list = LoadPracticeList(data_);
  const BlobCache cache(data_ / "blobs");
  const auto fetch = [&](const Sha256& name) -> Result<Bytes> {
    if (auto cached = cache.Find(name)) return std::move(*cached);
    return Status(Code::kNotFound, "not in the cache");
  };
  Catalogue out;
  for (const auto& [name, hash] : list.exercises) {
    auto facts = FactsOf(hash, fetch);
    if (!facts.ok() || facts->graded) continue;
    const auto exercise = scene::ExerciseFromJson(AsText(*fetch(hash)));
    const Sha256& finished = exercise->target.prepared;
    if (!HasScene(cache, exercise->scene) || !(finished.IsZero() || HasScene(cache, finished)))
      continue;
    Catalogue::Exercise& listed = out.exercises.emplace_back();
    listed.name = exercise->name;
    listed.title = exercise->title;
    listed.exercise = hash;
    listed.scene = exercise->scene;
    listed.facts = std::move(*facts);
  }
  for (const auto& [name, hash] : list.profiles) {
    const auto text = cache.Find(hash);
    if (!text) continue;
    auto profile = scene::ProfileFromJson(AsText(*text));
    if (profile.ok()) out.profiles.push_back({profile->name, profile->title, hash});
  }
  return out;
}

Result<PreparedAttempt> Workplace::PreparePractice(const Catalogue::Exercise& exercise,
                                                   const Catalogue::Profile& profile) const {
  ENAMEL_ASSIGN_OR_RETURN(auto prepared, FromCache(exercise.exercise, profile.profile));
  // The list is a file that somebody can write; the document is what its hash says.
  if (prepared.exercise.graded) {
    return Status(Code::kForbidden,
                  "exercise '" + prepared.exercise.name + "' is graded, and needs the server");
  }
  prepared.terms.outline = true;
  return prepared;
}

}  // namespace enamel::station
