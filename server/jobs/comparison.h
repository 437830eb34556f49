#pragma once

#include "server/storage/parts.h"

namespace enamel::server {

// Whether there is something to compare attempts at this version with: a reference, or the prepared
// tooth that its target names. Errors: the store's.
Result<bool> HasComparison(Parts<ContentStore, ReferenceStore> store, const ExerciseRow& version);

}  // namespace enamel::server
