#pragma once

#include "server/storage/judging/reference_rows.h"
#include "server/storage/recordings/stored_blobs.h"

namespace enamel::server {

// Whether there is something to compare attempts at this version with: a reference, or the prepared
// tooth that its target names. Errors: the store's.
Result<bool> HasComparison(StoredBlobs& blobs, ReferenceRows& references,
                           const ExerciseRow& version);

}  // namespace enamel::server
