#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "common/base/mutex.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/builtin/exercises.h"
#include "common/scene/builtin/layer.h"
#include "common/scene/builtin/rubrics.h"

namespace enamel::scene {
namespace {

// Height of a turned tooth's face over a point of the scene, m; `lo_m` beside the tooth.
double FaceHeight_m(const ToothShape& tooth, double x_m, double y_m, double lo_m) {
  double z = tooth.hi.y * 1e-3;
  // The field says no more than the distance, and never less than nothing.
  constexpr double kNear_m = 1e-7, kLeast_m = 1e-6;
  while (z > lo_m) {
    const double d = ToothField(tooth, FromBuccalUp({x_m, y_m, z})).distance_m;
    if (d < kNear_m) return z;
    z -= std::max(d, kLeast_m);
  }
  return lo_m;
}

// Half a millimetre off the labial face of an incisor, with a ball of 1.6 mm that leaves a chamfer
// all around: 5.6 mm wide, from 0.95 mm above the cervical line, along it, to 0.8 mm short of the
// edge. Nearer to that line half a millimetre is all the enamel there is. Source of the depth:
// textbooks ask for 0.3 mm near the gum to 0.7 mm near the edge.
constexpr std::array<int32_t, 2> kVeneerHalf_um = {2'800, 4'400};
constexpr int32_t kVeneerDepth_um = 500, kVeneerBur_um = 800, kVeneerChamfer_um = 750;
constexpr int32_t kVeneerAboveLine_um = 950;

PreparationPart MakeVeneerPart(const ToothShape& tooth, const PointUm& at) {
  PreparationPart part;
  part.half_size_um = {kVeneerHalf_um[0] + 100, kVeneerHalf_um[1] + 100};
  part.top_um = {0, 0, static_cast<int32_t>(std::ceil(tooth.hi.y * 1e3)) - at[2]};
  part.depth_um = 6'000;
  std::map<std::pair<int64_t, int64_t>, double> known;
  Layer layer;
  layer.surface_m = [&](double x_m, double y_m) {
    auto [height, unknown] = known.try_emplace({std::lround(x_m * 1e6), std::lround(y_m * 1e6)});
    if (unknown) height->second = FaceHeight_m(tooth, x_m, y_m, tooth.hi.y * 1e-3 - 6e-3);
    return height->second;
  };
  layer.thick_m = kVeneerDepth_um * 1e-6;
  layer.end_radius_m = kVeneerBur_um * 1e-6;
  layer.round_end = true;
  for (size_t i = 0; i < 2; ++i) {
    layer.axis_half_m[i] = (kVeneerHalf_um[i] - kVeneerChamfer_um) * 1e-6;
  }
  layer.axis_may = [&](double x_m, double y_m) {
    const dvec3 own_mm = 1e3 * FromBuccalUp({x_m, y_m, 0});
    const double line_mm = CervicalHeight_mm(tooth, own_mm.x);
    return own_mm.z >= line_mm + 1e-3 * (kVeneerAboveLine_um + kVeneerChamfer_um);
  };
  constexpr int32_t kStep_um = 250;
  part.relief = ReliefOf(layer, part, at, kStep_um);
  part.depth_um = *std::max_element(part.relief.below_um.begin(), part.relief.below_um.end());
  return part;
}

// It takes thousands of questions to the tooth's field: the last one is kept.
PreparationPart VeneerPart(const ToothShape& tooth, const PointUm& at) {
  static Mutex mutex;
  static std::string name;
  static PointUm place;
  static PreparationPart part;
  MutexLock lock(mutex);
  if (name != tooth.name || place != at) {
    part = MakeVeneerPart(tooth, at);
    name = tooth.name, place = at;
  }
  return part;
}

}  // namespace

Exercise VeneerExercise(const Scene& scene, const ToothShape& tooth, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("veneer", scene);
  e.title = "Veneer, reduction of the labial face";
  e.isolation = Isolation::kNone;
  e.bur_shape = cutting::BurShape::kSphere;  // "round-16"
  e.bur_radius_um = kVeneerBur_um;
  e.bur_length_um = 0;
  e.target.landmark = "labial_face";
  const PreparationPart part = VeneerPart(tooth, scene.landmarks.at(e.target.landmark));
  e.target.half_size_um = {part.half_size_um[0], part.half_size_um[1], 0};
  e.target.depth_um = part.depth_um - part.top_um[2];
  e.target.parts = {part};
  e.instructions =
      "The labial face is up, and the root points away from you. Take " + Mm(kVeneerDepth_um) +
      " off the face, following its curve, over " + Mm(2 * kVeneerHalf_um[0]) +
      " from mesial to distal and " + Mm(2 * kVeneerHalf_um[1]) +
      " from gingival to incisal, with a chamfer all around. Keep the incisal edge and the "
      "contacts.";
  e.rubric = ShapeRubric("veneer-labial", {600, 1'200});
  e.rubric.prices = PricesOfFace();
  e.rubric.criteria = HandCriteria(8, 2, {600, 1'200});
  AddCritical(e.rubric, CriticalOfPulp());
  AddCritical(e.rubric, CriticalOfFace());
  return e;
}

}  // namespace enamel::scene
