#pragma once

#include "common/cutting/volume.h"
#include "common/scene/attempt_documents.h"

// Targets that a volume gives: the tooth as it should be in the end, from a dentist's scan or a
// reference's cut. It is stored as a scene of its own on the same voxels, which the target names
// (CavityTarget::prepared): documents and blobs as every scene's, so that whatever keeps, fetches
// and shows scenes has it too. Thread safety: functions, any thread. Not real-time.
namespace enamel::scene {

// A target that is a tooth: the tooth, and the box around the solid to remove.
struct PreparedTooth {
  cutting::Volume volume;
  dvec3 lo_m{0}, hi_m{0};
};

// Reads the tooth that the target names into target.prepared_tooth; does nothing where it names
// none. Errors: `fetch`'s and the documents' own; kConflict where the tooth is on other voxels than
// `initial`; kInvalidInput where there is nothing to remove, something would have to grow, or the
// solid to remove is outside the target's box.
Status LoadPreparedTarget(const cutting::Volume& initial, const FetchContent& fetch,
                          CavityTarget& target);

// A target for `prepared`, stored as the scene of this hash, with `tolerance_um` of leeway on all
// sides and as much again of container. Its landmark is the one of `scene` about which its box is
// smallest. prepared_tooth is set. Errors: kConflict and kInvalidInput as above; kInvalidInput
// where no landmark is above the solid to remove.
Result<CavityTarget> TargetFromPrepared(const Scene& scene, const cutting::Volume& initial,
                                        cutting::Volume prepared, const Sha256& prepared_scene,
                                        int32_t tolerance_um);

}  // namespace enamel::scene
