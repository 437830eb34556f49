#pragma once

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/cutting/volume.h"

namespace enamel::scene {

// The stored form of a volume (schemas/volume_blob.md): built once, named by its SHA-256, loaded by
// station and server alike; neither rebuilds it. Deterministic: equal volumes give equal bytes.
Bytes EncodeVolume(const cutting::Volume& volume);
// Bounded: refuses grids over 4 GiB, sizes that do not match, unknown versions and tissues.
Result<cutting::Volume> DecodeVolume(ByteView blob);

}  // namespace enamel::scene
