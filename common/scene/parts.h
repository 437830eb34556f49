#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/scene/types.h"

// Which parts of a scene an attempt carries: the compiler's decisions. 'enamel-lab explain'
// measures the worth of each.
namespace enamel::scene {

enum class PartId {
  kLabels,      // a tissue per voxel
  kUniform,     // bricks without a surface, stored
  kNeighbour,   // bricks of adjacent teeth
  kTurning,     // resistance to turning the bur
  kTorque,      // torque for the device
  kTouchCues,   // knock on contact, chatter of the bur
  kOtherBurs,   // tables of burs the exercise does not use
  kSurface,     // triangles for the window
  kMouth,       // gingiva and neighbours that are only drawn
  kRubberDam,   // in place of the gingiva
  kAntagonist,  // the opposite teeth, only drawn
  kMirror,      // the scene once more, in a mirror
  kBusWrite,    // force to the device
  kForceBounds,
  kStateHash,
};

struct Part {
  PartId id;
  std::string_view name;  // "labels"
  bool kept;
  std::string why;
};

// The purpose of the plan.
struct Use {
  bool window = false;
  bool replay = false;  // a recording is re-run: no device
  bool torque = false;  // the device has six driven axes and a peak torque above 0
};

// Every part once, in the order of PartId. Requires: CompilePlan and CheckVolume accept the scene.
std::vector<Part> ListParts(const Scene& scene, const Exercise& exercise, const Use& use);

}  // namespace enamel::scene
