#pragma once

#include "common/base/bytes.h"
#include "common/base/result.h"
#include "common/base/sha256.h"
#include "common/cutting/volume.h"

namespace enamel::scene {

// The stored form of a volume (schemas/volume_blob.md): built once, named by its SHA-256, loaded by
// station and server alike; neither rebuilds it. Deterministic: equal volumes give equal bytes.
// Thread safety: functions, any thread.
Bytes EncodeVolume(const cutting::Volume& volume);
// Bounded: refuses grids over 4 GiB, sizes that do not match, unknown versions and tissues; and a
// change, with kConflict.
Result<cutting::Volume> DecodeVolume(ByteView blob);

// A change: what a volume differs by from another one that is stored, whose blob's hash is `from`. A
// cut tooth takes a tenth of its bytes so. Deterministic. Requires: equal grids.
Bytes EncodeChange(const cutting::Volume& volume, const cutting::Volume& before,
                   const Sha256& from);
// The blob that a change is from; zero: this is a whole volume. Errors: of its header, as
// DecodeVolume.
Result<Sha256> ChangedFrom(ByteView blob);
// `before`: the volume of that blob. Errors: as DecodeVolume; kConflict when the grids differ or the
// blob is no change.
Result<cutting::Volume> DecodeChange(ByteView blob, const cutting::Volume& before);

}  // namespace enamel::scene
