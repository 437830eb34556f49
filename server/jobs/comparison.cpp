#include "server/jobs/comparison.h"

#include "common/scene/json/json.h"

namespace enamel::server {

Result<bool> HasComparison(StoredBlobs& blobs, ReferenceRows& references,
                           const ExerciseRow& version) {
  ENAMEL_ASSIGN_OR_RETURN(const auto reference, references.ReferenceFor(version.id));
  if (reference) return true;
  const auto text = blobs.GetBlob(version.content);
  // A document that cannot be read names nothing; who needs it for more says what is wrong with it.
  if (!text.ok()) return false;
  const auto exercise = scene::ExerciseFromJson(AsText(*text));
  return exercise.ok() && !exercise->target.prepared.IsZero();
}

}  // namespace enamel::server
