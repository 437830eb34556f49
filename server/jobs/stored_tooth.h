#pragma once

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "server/storage/judging/result_rows.h"
#include "server/storage/recordings/stored_blobs.h"

// Teeth in the store, and an attempt's surface. Thread safety: functions, any thread; they block for
// the store, and AttemptSurface meshes a whole tooth.
namespace enamel::server {

// A whole volume: a scene's. Errors: the store's, DecodeVolume's.
Result<cutting::Volume> StoredVolume(StoredBlobs& blobs, const Sha256& hash);
// The tooth that an attempt left: kept as what it differs by from its scene's. Errors: the same.
Result<cutting::Volume> CutTooth(StoredBlobs& blobs, const Sha256& hash);

// The surface of an attempt with its deviation (surface_blob.h), which nothing keeps: made of the
// tooth and the deviation. Errors also: kConflict when it is not what the signed result names.
Result<Bytes> AttemptSurface(StoredBlobs& blobs, const AttemptResult& result);

}  // namespace enamel::server
