#include "common/scene/arrangement.h"

#include <algorithm>
#include <cmath>

namespace enamel::scene {
namespace {

using cutting::Tissue;

// Negative inside; never more than the true distance.
double LesionDistance_mm(const Lesion& lesion, const dvec3& p_mm) {
  // |q| grows by at most 1 / (least half extent) per mm, so the product below is never too long.
  dvec3 q = (p_mm - lesion.middle) / lesion.half;
  return (std::sqrt(Dot(q, q)) - 1) * std::min({lesion.half.x, lesion.half.y, lesion.half.z});
}

FieldSample PlacedField(const PlacedTooth& tooth, const dvec3& point_m) {
  dvec3 own_m = point_m - dvec3(tooth.x_mm * 1e-3, 0, 0);
  FieldSample out = ToothField(*tooth.shape, own_m);
  if (tooth.neighbour) {
    out.tissue = Tissue::kNeighbour;
    // One tissue throughout: any margin up to the tooth's size is valid.
    out.tissue_margin_m = 1;
    return out;
  }
  double lesion_mm = 1e3;
  for (const Lesion& l : tooth.lesions)
    lesion_mm = std::min(lesion_mm, LesionDistance_mm(l, own_m * 1e3));
  if (lesion_mm < 0 && out.tissue != Tissue::kPulp) out.tissue = Tissue::kCaries;
  out.tissue_margin_m = std::min(out.tissue_margin_m, std::abs(lesion_mm) * 1e-3);
  return out;
}

struct Widest {
  double mesial_mm = 0, distal_mm = 0;
};
Widest WidestOf(const ToothShape& shape) {
  Widest out;
  // Where a section is widest it hardly changes with height: steps of 0.05 mm do.
  for (double z = shape.cervical_z; z < shape.hi.z - 1; z += 0.05) {
    auto half = SectionAt_mm(shape, z);
    out.mesial_mm = std::max(out.mesial_mm, half[0]);
    out.distal_mm = std::max(out.distal_mm, half[1]);
  }
  return out;
}

}  // namespace

FieldSample ArrangementField(const Arrangement& arrangement, const dvec3& point_m) {
  FieldSample nearest = PlacedField(arrangement.teeth.at(0), point_m);
  for (size_t i = 1; i < arrangement.teeth.size(); ++i) {
    FieldSample other = PlacedField(arrangement.teeth[i], point_m);
    if (other.distance_m < nearest.distance_m) nearest = other;
  }
  return nearest;
}

Box BoundsOf(const Arrangement& arrangement) {
  Box box{dvec3(1), dvec3(-1)};
  for (const PlacedTooth& t : arrangement.teeth) {
    const dvec3 shift(t.x_mm * 1e-3, 0, 0);
    const auto [lo, hi] = BoundsOf_m(*t.shape);
    box.lo_m = glm::min(box.lo_m, lo + shift);
    box.hi_m = glm::max(box.hi_m, hi + shift);
  }
  return box;
}

double NextToMesially_mm(const ToothShape& tooth, const ToothShape& neighbour, double gap_mm) {
  return tooth.Along(WidestOf(tooth).mesial_mm + WidestOf(neighbour).distal_mm + gap_mm);
}

double NextToDistally_mm(const ToothShape& tooth, const ToothShape& neighbour, double gap_mm) {
  return -tooth.Along(WidestOf(tooth).distal_mm + WidestOf(neighbour).mesial_mm + gap_mm);
}

std::vector<Lesion> FissureCaries(const ToothShape& tooth, CariesDepth depth) {
  const dvec3 fossa = FossaBottom_m(tooth) * 1e3;
  switch (depth) {
    case CariesDepth::kShallow:
      return {{fossa, {0.45, 0.3, 1.2}}, {fossa - dvec3(0, 0, 1.4), {1.25, 0.95, 0.55}}};
    case CariesDepth::kMedium:
      return {{fossa, {0.55, 0.35, 1.3}}, {fossa - dvec3(0, 0, 1.7), {1.5, 1.1, 0.75}}};
    case CariesDepth::kDeep:
      break;
  }
  return {{fossa, {0.6, 0.4, 1.4}}, {fossa - dvec3(0, 0, 2.3), {1.9, 1.4, 1.25}}};
}

std::vector<Lesion> MesialCaries(const ToothShape& tooth) {
  // Just below the height at which the molar's mesial face is widest, 0.4.
  constexpr double kContact_z = 0.2;
  dvec3 face(tooth.Along(SectionAt_mm(tooth, kContact_z)[0]), 0, kContact_z);
  return {{face, {1.5, 0.7, 0.5}}, {face - dvec3(tooth.Along(1.7), 0, 0.1), {0.7, 1.1, 0.9}}};
}

}  // namespace enamel::scene
