#pragma once

#include <optional>
#include <vector>

#include "common/scene/builtin/tooth_shape.h"

// Teeth side by side, with caries: the parts of a built-in scene.
namespace enamel::scene {

// Soft tissue in a tooth: an ellipsoid. Where it reaches, enamel and dentin are caries; the pulp
// stays. Several that overlap make the mushroom of a lesion that is narrow in enamel and spreads
// under it. Millimetres, in the scene's frame about the tooth.
struct Lesion {
  dvec3 middle{0}, half{1};
};

struct PlacedTooth {
  const ToothShape* shape = nullptr;
  double x_mm = 0;         // shift along x
  bool neighbour = false;  // all of it is kNeighbour
  std::vector<Lesion> lesions;
};

struct Arrangement {
  std::vector<PlacedTooth> teeth;  // must not overlap
};

// Signed distance and tissue, metres. Thread safety: any thread.
FieldSample ArrangementField(const Arrangement& arrangement, const dvec3& point_m);

// Box that holds all teeth, metres.
struct Box {
  dvec3 lo_m, hi_m;
};
Box BoundsOf(const Arrangement& arrangement);

// Shift along x, in mm, of the tooth mesial (or distal) of `tooth`, so that their crowns come
// within `gap_mm` of each other at the widest heights of both.
double NextToMesially_mm(const ToothShape& tooth, const ToothShape& neighbour, double gap_mm);
double NextToDistally_mm(const ToothShape& tooth, const ToothShape& neighbour, double gap_mm);

// Occlusal caries under the fossa: through the enamel at its bottom and spread in the dentin. The
// last of the lesions is the one in the dentin. Chosen, of the molar: shallow ends in the outer quarter
// of the dentin, medium in the outer half, deep 1.0 to 1.5 mm above the pulp.
enum class CariesDepth { kShallow, kMedium, kDeep };
std::vector<Lesion> FissureCaries(const ToothShape& tooth, CariesDepth depth);
// Caries of the mesial face just under the contact with the next tooth.
std::vector<Lesion> MesialCaries(const ToothShape& tooth);

}  // namespace enamel::scene
