#include <algorithm>
#include <iterator>

#include "common/scene/builtin/builtin.h"
#include "common/scene/builtin/exercises.h"
#include "common/scene/builtin/layer.h"
#include "common/scene/builtin/rubrics.h"
#include "common/scene/tooth_number.h"

namespace enamel::scene {
namespace {

// What a crown's preparation leaves of a tooth that is built in: as much off its walls and top as
// textbooks ask for (1 mm and 1.5 mm), less where the pulp would keep less than 0.9 mm of cover;
// the stump that the tooth's own sections give with that, its walls opened to 7 to 14 degrees where
// the sections would give less or more. Heights are below the landmark crown_top; x is mesial here.
struct CrownTask {
  int place;         // of the permanent tooth in its quadrant, from the middle
  int32_t depth_um;  // of the shoulder: above the cervical line
  int32_t off_top_um, off_walls_um;
  Stump::Section foot, table;
  int32_t corner_um;
};
constexpr CrownTask kCrowns[] = {
    {6, 6'500, 1'200, 800, {{0, 250}, {4'100, 4'050}}, {{50, -350}, {3'350, 3'050}}, 1'800},
    {4, 6'500, 1'500, 1'000, {{0, 50}, {1'900, 3'350}}, {{-50, 150}, {1'150, 2'450}}, 700},
    {1, 9'000, 1'500, 1'000, {{0, 100}, {2'500, 2'300}}, {{50, 400}, {2'100, 500}}, 450}};

const CrownTask* CrownOf(const Scene& scene) {
  const ToothShape* tooth = ShapeOf(scene);
  if (tooth == nullptr || IsDeciduous(tooth->fdi)) return nullptr;
  const auto* it = std::ranges::find(kCrowns, tooth->fdi % 10, &CrownTask::place);
  return it == std::end(kCrowns) ? nullptr : it;
}

// The table of a crown's stump: the tooth's own relief, so deep below it.
void AddOcclusalRelief(const Scene& scene, const PointUm& at, int32_t off_um, int32_t tip_um,
                       PreparationPart& part) {
  const ToothShape* tooth = ShapeOf(scene);
  if (tooth == nullptr) return;
  Layer layer;
  // On over the tooth's sides, which are the walls' to reduce.
  layer.surface_m = [=](double x_m, double y_m) {
    return OcclusalHeight_mm(*tooth, x_m * 1e3, y_m * 1e3) * 1e-3;
  };
  layer.thick_m = off_um * 1e-6;
  layer.end_radius_m = tip_um * 1e-6;
  for (size_t i = 0; i < 2; ++i) {
    layer.axis_half_m[i] = (part.stump.foot.half_um[i] + 1'000) * 1e-6;
  }
  constexpr int32_t kStep_um = 500;
  part.relief = ReliefOf(layer, part, at, kStep_um);
}

// Only the height of a crown that is not built in is known: the task is what the reference took.
constexpr int32_t kUnknownCrownDepth_um = 6'500;

}  // namespace

Exercise CrownExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("crown", scene);
  e.title = "Crown preparation";
  e.isolation = Isolation::kNone;
  e.bur_shape = cutting::BurShape::kCone;  // "taper-16"
  e.bur_radius_um = 800;
  e.bur_length_um = 8'000;
  e.bur_narrow_radius_um = 500;
  // Of fine grit (exercises.cpp): for margins and the form of cusps.
  e.other_burs = {OfferedBur("flame-12", "806 314 243 514 012")};
  e.target.landmark = "crown_top";
  // Wider than the widest built-in crown, 11 x 10.5 mm.
  e.target.half_size_um = {6'000, 6'000, 0};
  e.target.depth_um = kUnknownCrownDepth_um;
  const CrownTask* crown = CrownOf(scene);
  const bool anterior = IsAnterior(scene.tooth);
  const std::string top = anterior ? "incisal edge" : "occlusal surface";
  const std::string highest = anterior ? "the incisal edge" : "the highest cusp";
  if (crown == nullptr) {
    e.instructions = "Reduce the " + top +
                     " and all walls as in the reference, down to a shoulder " +
                     Mm(e.target.depth_um) + " below " + highest + ".";
  } else {
    e.target.depth_um = crown->depth_um;
    PreparationPart part;
    part.outline = PreparationPart::Outline::kStump;
    part.half_size_um = {e.target.half_size_um[0], e.target.half_size_um[1]};
    part.depth_um = crown->depth_um;
    part.stump = {crown->foot, crown->table, crown->off_top_um, crown->corner_um};
    part.stump.foot.middle_um[0] *= MesialX(scene.tooth);
    part.stump.table.middle_um[0] *= MesialX(scene.tooth);
    if (const auto at = scene.landmarks.find(e.target.landmark); at != scene.landmarks.end()) {
      AddOcclusalRelief(scene, at->second, crown->off_top_um, e.bur_narrow_radius_um, part);
    }
    e.target.parts = {part};
    const std::string take_top = "Take " + Mm(crown->off_top_um) + " off the " + top +
                                 (anterior ? "" : " and keep the form of its cusps and fossa");
    e.instructions = take_top + ". Reduce all walls by at least " + Mm(crown->off_walls_um) +
                     ", down to a shoulder " + Mm(crown->depth_um) + " below " + highest + ".";
  }
  e.instructions += Has(scene, cutting::Tissue::kNeighbour)
                        ? " Do not touch the adjacent teeth or the root."
                        : " Do not touch the root.";
  e.time_limit_s = 1'800;
  // A simulated good hand takes a quarter of an hour.
  e.rubric = CrownRubric();
  return e;
}

}  // namespace enamel::scene
