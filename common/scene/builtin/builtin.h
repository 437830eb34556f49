#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"
#include "common/cutting/volume.h"
#include "common/scene/types.h"

namespace enamel::scene {

struct BuiltScene {
  Scene scene;  // volume hash filled in
  cutting::Volume volume;
};

// A scene the project makes itself, no download.
struct BuiltinScene {
  std::string_view name;     // "molar"
  std::string_view summary;  // one line for lists
};
std::span<const BuiltinScene> BuiltinScenes();
std::vector<std::string> BuiltinSceneNames();

// Behind a scene's name: the same tooth, with the tissue of ByLoadMaterial (scene/material.h).
inline constexpr std::string_view kByLoadSuffix = "-by-load";

// The memory that a volume may take with every brick stored; BuildBuiltinScene's default limit.
inline constexpr size_t kDefaultSceneBytes = size_t{2} << 30;

// Errors: kNotFound with the names there are; kInvalidInput outside 5 to 500 um; kTooLarge with the
// finest voxel that would fit.
Result<BuiltScene> BuildBuiltinScene(std::string_view name, int32_t voxel_nm,
                                     size_t max_bytes = kDefaultSceneBytes);
// Its tooth alone, in a grid that lies elsewhere by `moved_nm`. Requires: a name of BuiltinSceneNames, a size that builds.
cutting::Volume BuildBuiltinVolume(std::string_view name, int32_t voxel_nm, const ivec3& moved_nm);

// The paper's three devices with the provenance of every number: omega3, phantom_desktop, bhhd3;
// pointer, for what has no motors (mouse, 6-DoF mouse); woodenhaptics_v2015, polhem_v1, polhem_v3,
// inverse3, minverse, touch, touch_x, falcon, omega6 and omega7, which ask for what nobody published (AskedFor); and last sigma7, which drives six axes.
std::vector<DeviceProfile> BuiltinProfiles();

// False for "pointer": its force is shown, not felt.
bool HasMotors(const DeviceProfile& profile);

// Class I occlusal cavity on any scene with an "occlusal_centre" landmark.
Exercise ClassOneExercise(const Scene& scene, const Sha256& scene_hash);

// Every exercise the project makes for a scene, by the landmarks it has:
//   occlusal_centre  class-1: a box in the fossa
//   caries           caries: excavation of the lesion under the fossa
//   mesial_box       class-2: the box of a mesial class II cavity, beside the neighbour
//   crown_top        crown: a crown preparation down to the height of the margin
//   class_5          class-5: a box in the gingival third of a face that is up
//   labial_face      veneer: half a millimetre off an incisor's face, which is up
//   a preparation    its name: the shape on the practice block
// and each drawing of schemas/exercises for that scene (drawn.h): cavities with the outlines of textbooks.
// The parts of a target say what has to go. The crown of a tooth that is not built in has no parts: its reference says it.
std::vector<Exercise> BuiltinExercises(const Scene& scene, const Sha256& scene_hash);

// The exercise that asks for a prepared tooth (prepared_target.h). Its rubric has
// a price for every kind of region.
Exercise PreparedExercise(const Scene& scene, const Sha256& scene_hash, const CavityTarget& target);

// A point of a tooth whose buccal side is up, in the tooth's own frame (tooth_shape.h); and back.
inline dvec3 FromBuccalUp(const dvec3& p) { return {p.x, p.z, -p.y}; }
inline dvec3 ToBuccalUp(const dvec3& p) { return {p.x, -p.z, p.y}; }

// B per tissue with provenance, as used by built-in and imported scenes.
std::vector<TissueSpec> DefaultTissues(const std::vector<cutting::Tissue>& present);

}  // namespace enamel::scene
