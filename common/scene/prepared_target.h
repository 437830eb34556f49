#pragma once

#include "common/cutting/volume.h"
#include "common/scene/attempt_documents.h"

// Targets that a volume gives: the tooth as it should be in the end, from a dentist's scan or a
// reference's cut. It is stored as a scene of its own on the same voxels, which the target names
// (CavityTarget::prepared): documents and blobs as every scene's, so that whatever keeps, fetches and
// shows scenes has it too.
// Thread safety: functions, any thread. Not real-time.
namespace enamel::scene {

// What a target asks for: the tooth, and the box around what has to go of it.
struct PreparedTooth {
  cutting::Volume volume;
  dvec3 lo_m{0}, hi_m{0};
};

// Reads the tooth that the target names into target.prepared_tooth; nothing to do where it names
// none. Errors: `fetch`'s and the documents' own; kConflict where it is on other voxels than
// `initial`; kInvalidInput where nothing has to go, something would have to grow, or what has to go
// lies beyond the target's box.
Status LoadPreparedTarget(const cutting::Volume& initial, const FetchContent& fetch,
                          CavityTarget& target);

// The target that asks for `prepared`, stored as the scene of this hash, and gives `tolerance_um` of
// leeway on all sides and as much again of container: the landmark of `scene` about which its box is
// smallest. prepared_tooth is set. Errors: kConflict and kInvalidInput as above; kInvalidInput where
// no landmark lies above what has to go.
Result<CavityTarget> TargetFromPrepared(const Scene& scene, const cutting::Volume& initial,
                                        cutting::Volume prepared, const Sha256& prepared_scene,
                                        int32_t tolerance_um);

}  // namespace enamel::scene
