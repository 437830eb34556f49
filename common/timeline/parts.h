#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/base/keep_going.h"
#include "common/cutting/volume.h"
#include "common/timeline/part_mesh.h"

// Divides a tooth for playback into bricks whose triangles change and bricks that the attempt
// never changes (schemas/surface_timeline.md, "Parts"). The second kind is simplified: a tooth has
// half a million triangles, and some thousands look the same.
// Thread safety: functions, any thread. Not real-time: seconds.
namespace enamel::timeline {

// The ball around what was removed; radius 0: nothing was.
struct CutBall {
  std::array<int32_t, 3> centre_um{};
  int32_t radius_um = 0;

  bool operator==(const CutBall&) const = default;
};

struct PartMeshes {
  PartMesh end;    // of the changing bricks, as the tooth is
  PartMesh still;  // of all others
};

// How far a triangle may be from the surface that it stands for. A pixel of a whole tooth on the page
// is 30 um.
inline constexpr double kTriangleError_um = 25, kNeighbourError_um = 60;

// `changing`: per brick. Vertices on the border between both parts stay as they are, so that the
// triangles made of the changing bricks' samples join without a gap. Requires: samples in steps of
// 1/64 voxel, as QuantiseBrick has them.
// `keep_going` is asked between bricks and before each part is simplified, which takes about a second for a molar of
// 0.05 mm.
PartMeshes MeshesOf(const cutting::Volume& tooth, const std::vector<uint8_t>& changing,
                    const KeepGoing& keep_going = {});

// `changed`: bricks that may differ.
CutBall CutBallOf(const cutting::Volume& initial, const cutting::Volume& tooth,
                  const std::vector<int32_t>& changed);

// The volume with its samples in steps of 1/64 voxel.
cutting::Volume Quantised(const cutting::Volume& volume);

}  // namespace enamel::timeline
