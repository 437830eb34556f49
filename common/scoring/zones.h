#pragma once

#include <array>
#include <optional>

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/scene/preparation.h"
#include "common/scene/prepared_target.h"
#include "common/scene/types.h"

// Volumes that went: from the zones around a cavity's target, and per tissue.
namespace enamel::scoring {

// Axis-aligned in the scene frame, open at the top (+z), metres.
struct OpenBox {
  dvec3 lo_m{0};
  dvec3 hi_m{0};     // z unused
  int mesial_x = 1;  // scene::MesialX: at which end of x its mesial side is
};

// The target, and the target grown by the leeway, and that grown by the container; each contains
// the one before.
struct ZoneBoxes {
  OpenBox target, leeway, container;
  // For a target with parts, which the boxes only bound: how far its leeway and container extend
  // beyond it.
  std::optional<scene::Preparation> shape;
  scene::Growth leeway_growth, container_growth;
  // For a target that is a prepared tooth; the target's box is around its hollow. Leeway and
  // container are teeth with the hollow grown by the leeway's side and the container, once
  // GrowZones has made them.
  std::shared_ptr<const scene::PreparedTooth> prepared;
  std::shared_ptr<const cutting::Volume> leeway_gone, container_gone;
};
// Errors: kInvalidInput when the landmark is not in the scene; kNotFound when the target names a
// prepared tooth that was not loaded (LoadPreparedTarget).
Result<ZoneBoxes> BoxesOf(const scene::Scene& scene, const scene::CavityTarget& target);

// Removal beyond the reference counts as near up to this distance from its cut: the exercise's
// leeway, and at least what voxels can resolve.
double NearOf_m(const scene::CavityTarget& target, const cutting::GridSpec& grid);

// Solid inside a box before, and how much of it went, m^3. Voxels that a box face and a surface
// both cut are split at the face and read in parts, so that a cut along a zone's face is not booked
// to both sides of it.
struct BoxVolume {
  double solid_m3 = 0;
  double removed_m3 = 0;
};
// Requires: equal grids.
BoxVolume MeasureBox(const cutting::Volume& initial, const cutting::Volume& final_volume,
                     const OpenBox& box);

// The target, the target with its leeway, and that with its container: the boxes, or the shapes in
// them. For a prepared tooth: the removed part of the solid that it lacks; leeway and container
// need GrowZones. At a shape's face a voxel counts by the share of it inside a plane at the face's
// distance, evenly filled, and removal counts from the inside. Requires: equal grids.
enum class Zone { kTarget, kLeeway, kContainer };
BoxVolume MeasureZone(const cutting::Volume& initial, const cutting::Volume& final_volume,
                      const ZoneBoxes& zones, Zone zone);

// Makes the leeway and the container of a prepared tooth; others need none. Takes a second for a
// tooth of 0.05 mm.
void GrowZones(const cutting::Volume& initial, ZoneBoxes& zones);

// Solid that went, per tissue, m^3. Requires: equal grids.
std::array<double, cutting::kTissueCount> RemovedPerTissue_m3(const cutting::Volume& initial,
                                                              const cutting::Volume& final_volume);

}  // namespace enamel::scoring
