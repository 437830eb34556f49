#include "common/scene/builtin/exercises.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "common/scene/arrangement.h"
#include "common/scene/builtin/builtin.h"
#include "common/scene/builtin/drawn.h"
#include "common/scene/builtin/rubrics.h"
#include "common/scene/preparation.h"
#include "common/scene/tooth_number.h"

namespace enamel::scene {
namespace {

using cutting::Tissue;

// Gentle: chatter like that of a handpiece held lightly, and an energy that moves no hand. 1 mW is
// what 0.1 N of chatter takes on the coarsest of the built-in devices (haptics/README.md).
constexpr TouchCueSpec kPracticeCues{250, 100, 200, 1'000};

// How far a side may be off, as a student reads it.
std::string SidesText() {
  return "A side that is off by at most 0.1 mm costs no points. Tissue that must stay begins " +
         Mm(kLeeway_um) + " beyond a side.";
}

// ISO numbers of what one would take (schemas/exercise.schema.json): diamonds of medium grit with a friction grip
// shank. No shape that cuts like "fissure-10" or "taper-16" was found in a source that could be read.
constexpr std::string_view kMediumRound = "806 314 001 524 016",
                           kMediumPear = "806 314 237 524 012";

int32_t Um(double mm) { return static_cast<int32_t>(std::lround(mm * 1e3)); }

CariesDepth CariesDepthOf(const Scene& scene) {
  if (scene.name.starts_with("molar-46-caries-shallow")) return CariesDepth::kShallow;
  return scene.name.starts_with("molar-46-caries-deep") ? CariesDepth::kDeep : CariesDepth::kMedium;
}

Exercise CariesExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("caries", scene);
  e.title = "Caries excavation";
  // For the soft floor.
  e.other_burs = {OfferedBur("round-16", kMediumRound)};
  e.instructions =
      "Open the lesion under the central fossa and remove all soft caries, with no more sound "
      "tissue than you need to reach it. Keep the pulp covered.";
  e.target.landmark = "caries";
  // The lesion's widest section and its bottom.
  const ToothShape* shape = ShapeOf(scene);
  const ToothShape& tooth = shape == nullptr ? LowerFirstMolar() : *shape;
  constexpr double kAround_mm = 0.05;
  const Lesion lesion = FissureCaries(tooth, CariesDepthOf(scene)).back();
  const double above_mm = FossaBottom_m(tooth).z * 1e3 - lesion.middle.z;
  e.target.half_size_um = {Um(lesion.half.x + kAround_mm), Um(lesion.half.y + kAround_mm), 0};
  e.target.depth_um = Um(above_mm + lesion.half.z + kAround_mm);
  e.rubric = CariesRubric();
  return e;
}

Exercise ShapeExercise(const Scene& scene, const Sha256& scene_hash, const Preparation& shape) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor(shape.name.c_str(), scene);
  e.title = shape.title;
  e.instructions = shape.title + ", with upright walls and a flat floor.";
  CavityTarget target = TargetFor(shape);
  target.leeway_side_um = e.target.leeway_side_um;
  target.leeway_bottom_um = e.target.leeway_bottom_um;
  target.container_um = e.target.container_um;
  e.target = std::move(target);
  e.isolation = Isolation::kNone;
  e.graded = false;
  e.touch_cues = kPracticeCues;
  e.rubric = ShapeRubric("practice-" + shape.name);
  return e;
}

// The exercises that the scene's landmarks and preparations give.
std::vector<Exercise> ExercisesOf(const Scene& scene, const Sha256& scene_hash) {
  std::vector<Exercise> out;
  auto has = [&](const char* landmark) { return scene.landmarks.count(landmark) != 0; };
  if (scene.up == Up::kBuccal) {
    const ToothShape* tooth = ShapeOf(scene);
    if (has("class_5")) out.push_back(ClassFiveExercise(scene, scene_hash));
    if (has("labial_face") && tooth) out.push_back(VeneerExercise(scene, *tooth, scene_hash));
    return out;
  }
  // A front tooth has no fossa to cut into; of an imported one nothing else is known.
  const bool front = IsAnterior(scene.tooth) && has("crown_top");
  const bool for_caries = has("caries") && !has("crown_top");
  if (has("occlusal_centre") && !front && !for_caries) {
    out.push_back(ClassOneExercise(scene, scene_hash));
  }
  if (has("caries")) out.push_back(CariesExercise(scene, scene_hash));
  if (has("mesial_box")) out.push_back(ClassTwoExercise(scene, scene_hash));
  if (has("crown_top")) out.push_back(CrownExercise(scene, scene_hash));
  for (const Preparation& p : scene.preparations) {
    if (has(p.name.c_str())) out.push_back(ShapeExercise(scene, scene_hash, p));
  }
  return out;
}

}  // namespace

bool Has(const Scene& scene, Tissue tissue) {
  return std::any_of(scene.tissues.begin(), scene.tissues.end(),
                     [&](const TissueSpec& t) { return t.tissue == tissue; });
}

std::string Mm(int32_t um) {
  std::string text = std::to_string(um / 1000) + "." + std::to_string(um / 100 % 10);
  if (um % 100 != 0) text += std::to_string(um / 10 % 10);
  return text + " mm";
}

std::string NameFor(const char* kind, const Scene& scene) {
  // 64 is all that a document takes as a name (json/read.h).
  return (std::string(kind) + "-" + scene.name).substr(0, 64);
}

const ToothShape* ShapeOf(const Scene& scene) {
  for (const ToothShape* tooth : BuiltinTeeth()) {
    if (scene.name.starts_with(tooth->name)) return tooth;
  }
  return nullptr;
}

Exercise ClassTwoExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("class-2", scene);
  e.title = "Class II cavity, mesial box";
  // For the corners of the box. An inverted cone for its floor would refuse voxels of 0.1 mm
  // (cutting/voxel_limit.h), on which schools practise too.
  e.other_burs = {OfferedBur("pear-12", kMediumPear)};
  e.target.landmark = "mesial_box";
  e.target.half_size_um = {990, 1'600, 0};
  e.target.depth_um = 3'500;
  e.instructions = "Cut the mesial box " + Mm(2 * e.target.half_size_um[1]) + " wide and " +
                   Mm(e.target.depth_um) +
                   " deep from the marginal ridge, open to the mesial side, with its axial wall " +
                   Mm(e.target.half_size_um[0]) +
                   " inside the middle of the ridge. Do not touch the adjacent tooth.";
  // Less than elsewhere: on the mesial side the neighbour stands 0.05 mm away.
  e.target.leeway_side_um = 100;
  e.rubric.name = "class-2-mesial";
  e.rubric.prices.push_back(PriceOfCaries());
  e.rubric.critical.clear();
  for (const auto& critical : {CriticalOfCavity(), CriticalOfPulp(), CriticalOfWidth(true),
                               CriticalOfContact(), CriticalOfCaries()}) {
    AddCritical(e.rubric, critical);
  }
  e.rubric.restorations = TolerancesOfCavity(true);
  e.rubric.criteria = HandCriteria(3, 2, {240, 600});
  return e;
}

// The gingival third of the buccal face of a tooth that is turned: 4 mm wide and 2 mm high, its
// lower edge 1 mm above the cervical line.
Exercise ClassFiveExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("class-5", scene);
  e.title = "Class V cavity, buccal";
  e.target.landmark = "class_5";
  e.target.half_size_um = {2'000, 1'000, 0};
  e.target.depth_um = 1'200;
  e.instructions = "The buccal side faces up, and the root points away from you. Cut a box " +
                   Mm(2 * e.target.half_size_um[0]) + " from mesial to distal, " +
                   Mm(2 * e.target.half_size_um[1]) + " from gingival to occlusal and " +
                   Mm(e.target.depth_um) +
                   " deep in the middle, with upright walls and a flat axial wall. " + SidesText() +
                   " Do not expose the pulp.";
  e.rubric.name = "class-5-buccal";
  // The walls are turned, and the tolerances of an occlusal cavity do not fit them.
  e.rubric.restoration = Restoration::kNone;
  e.rubric.restorations.clear();
  std::erase_if(e.rubric.critical,
                [](const RubricCritical& c) { return c.error == "gross_overextension"; });
  return e;
}

Exercise AccessExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  // To lift the roof from below, once the chamber is open.
  e.other_burs = {OfferedBur("round-16", kMediumRound)};
  e.rubric = ShapeRubric("access-cavity");
  return e;
}

Exercise PreparedExercise(const Scene& scene, const Sha256& scene_hash,
                          const CavityTarget& target) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("prepared", scene);
  e.title = "Preparation from an example";
  e.instructions = "Prepare the tooth like the example: remove what is marked, and keep " +
                   std::string(Has(scene, Tissue::kNeighbour) ? "the adjacent teeth and " : "") +
                   "the rest of the tooth. A place that is off by at most 0.1 mm is right, and "
                   "tissue that must stay begins " +
                   Mm(target.leeway_side_um) + " beyond it.";
  e.target = target;
  e.isolation = Isolation::kNone;
  e.time_limit_s = 1'800;
  e.rubric = ShapeRubric("prepared-tooth", {1'200, 2'400});
  e.rubric.prices = AllPrices();
  if (Has(scene, Tissue::kCaries)) e.rubric.prices.push_back(PriceOfCaries());
  return e;
}

std::vector<Exercise> BuiltinExercises(const Scene& scene, const Sha256& scene_hash) {
  std::vector<Exercise> out = ExercisesOf(scene, scene_hash);
  std::ranges::move(DrawnExercises(scene, scene_hash), std::back_inserter(out));
  if (!Has(scene, Tissue::kNeighbour)) return out;
  for (Exercise& e : out) {
    if (e.name.starts_with("crown")) AddCritical(e.rubric, {CriticalOfContact().back()});
  }
  return out;
}

Exercise ClassOneExercise(const Scene& scene, const Sha256& scene_hash) {
  const bool tooth = Has(scene, Tissue::kPulp);
  Exercise e;
  e.name = NameFor("class-1", scene);
  e.title = tooth ? "Class I occlusal cavity" : "Central box, as in a class I cavity";
  e.scene = scene_hash;
  e.bur_shape = cutting::BurShape::kCylinder;
  e.bur_radius_um = 500;
  e.bur_length_um = 4'000;
  e.time_limit_s = 900;
  // The rule for operative and endodontic work; impressions and margins of crowns need the gingiva.
  if (tooth) e.isolation = Isolation::kRubberDam;
  e.target.half_size_um = {2'000, 1'200, 0};
  // Otherwise its ends would be in the marginal ridges, 5.2 mm apart.
  if (scene.name.starts_with("premolar")) e.target.half_size_um = {1'600, 1'100, 0};
  e.target.depth_um = 2'000;
  // Thin enamel over a wide pulp: half a millimetre into the dentin. Chosen.
  if (IsDeciduous(scene.tooth)) {
    e.target.half_size_um = {1'500, 800, 0};
    e.target.depth_um = 1'300;
  }
  e.target.leeway_side_um = kLeeway_um;
  e.target.leeway_bottom_um = kLeeway_um;
  e.target.container_um = 500;
  e.instructions = "Cut a box of " + Mm(2 * e.target.half_size_um[0]) + " x " +
                   Mm(2 * e.target.half_size_um[1]) + ", " + Mm(e.target.depth_um) +
                   (tooth ? " deep from the central fossa" : " deep from the middle of the top") +
                   ", with upright walls and a flat floor. " + SidesText() +
                   (tooth ? " Do not expose the pulp." : "");
  e.rubric = ClassOneRubric(tooth);
  return e;
}

}  // namespace enamel::scene
