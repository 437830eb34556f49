#pragma once

#include "server/storage/judging/reference_rows.h"
#include "server/storage/recordings/stored_blobs.h"

namespace enamel::server {

// Whether somebody has cut what attempts at this version are compared with: a reference, or the
// prepared tooth that its target names. Without one they are compared with the target's own shape,
// which is enough for practice. Errors: the store's.
Result<bool> HasComparison(StoredBlobs& blobs, ReferenceRows& references,
                           const ExerciseRow& version);

}  // namespace enamel::server
