#include "server/jobs/comparison.h"

#include "common/scene/json/json.h"

namespace enamel::server {

Result<bool> HasComparison(StoredBlobs& blobs, ReferenceRows& references,
                           const ExerciseRow& version) {
  ENAMEL_ASSIGN_OR_RETURN(const auto reference, references.ReferenceFor(version.id));
  if (reference) return true;
  const auto text = blobs.GetBlob(version.content);
  // An unreadable document names nothing; code that needs more of it reports the error.
  if (!text.ok()) return false;
  const auto exercise = scene::ExerciseFromJson(AsText(*text));
  return exercise.ok() && !exercise->target.prepared.IsZero();
}

}  // namespace enamel::server
