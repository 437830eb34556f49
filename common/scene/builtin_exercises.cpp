#include <algorithm>
#include <cmath>

#include "common/scene/builtin.h"
#include "common/scene/preparation.h"

namespace enamel::scene {
namespace {

// Gentle: chatter like that of a handpiece held lightly, and an energy that moves no hand. 1 mW is
// what 0.1 N of chatter takes on the coarsest of the built-in devices (haptics/README.md).
constexpr TouchCueSpec kPracticeCues{250, 100, 200, 1'000};

RubricCriterion WallCriterion(const char* metric, const char* title, const char* comment) {
  RubricCriterion c{metric, title, "mm", 8, {}, comment, {}};
  // Negative is too little, positive too much. A wall is found to a quarter of a voxel
  // (schemas/score.md), so the 0.05 mm of full marks is beyond what the measure itself is off at
  // voxels of 0.05 mm.
  c.map = {{-0.3, 0}, {-0.05, 1}, {0.05, 1}, {0.3, 0}};
  return c;
}

// Where these points and limits come from is not recorded. Tests hold that they add up to 100
// (builtin_test.cpp); what moves with them is every score of the built-in exercises.
Rubric ClassOneRubric() {
  Rubric r;
  r.name = "class-1-occlusal";
  r.criteria = {
      {"zone_target_removed_percent",
       "Outline removed",
       "%",
       18,
       // A 1 mm bur cannot reach the corners: 2.2 % of this box.
       {{60, 0}, {93, 1}},
       "Part of the outline was left standing.",
       {}},
      {"zone_container_removed_mm3",
       "Sound tissue around kept",
       "mm3",
       12,
       {{0.05, 1}, {3, 0}},
       "Tissue beyond the tolerance was cut away.",
       {}},
      WallCriterion("wall_mesial_mm", "Mesial wall", "The mesial wall is not where it should be."),
      WallCriterion("wall_distal_mm", "Distal wall", "The distal wall is not where it should be."),
      WallCriterion("wall_buccal_mm", "Buccal wall", "The buccal wall is not where it should be."),
      WallCriterion("wall_lingual_mm", "Lingual wall",
                    "The lingual wall is not where it should be."),
      WallCriterion("floor_mm", "Pulpal floor", "The floor is too deep or too shallow."),
      {"deviation_rms_mm",
       "Closeness to the reference",
       "mm",
       12,
       {{0.05, 1}, {0.4, 0}},
       "The cavity's surface is far from the reference.",
       {}},
      {"pulp_exposed_mm2",
       "Pulp not exposed",
       "mm2",
       8,
       {{0, 1}, {0.05, 0}},
       "The pulp was exposed: the whole attempt fails.",
       0.0},
      {"force_sent_p95_n",
       "Light hand",
       "N",
       5,
       {{4, 1}, {8, 0}},
       "The bur was pressed too hard: let it cut.",
       {}},
      {"time_s", "Time", "s", 5, {{240, 1}, {600, 0}}, "The work took long.", {}},
  };
  return r;
}

// For shapes whose walls are not a box's: the distance to the reference says it all.
Rubric ShapeRubric(std::string name) {
  Rubric r;
  r.name = std::move(name);
  r.criteria = {
      {"deviation_rms_mm",
       "Closeness to the reference",
       "mm",
       40,
       {{0.05, 1}, {0.4, 0}},
       "The surface is far from the reference.",
       {}},
      {"deviation_p95_mm",
       "Nowhere far off",
       "mm",
       25,
       {{0.15, 1}, {0.8, 0}},
       "Somewhere the surface is far from the reference: see the heat map.",
       {}},
      {"zone_container_removed_mm3",
       "Nothing beside and below cut",
       "mm3",
       20,
       {{0.05, 1}, {3, 0}},
       "Material beyond the tolerance was cut away.",
       {}},
      {"force_sent_p95_n",
       "Light hand",
       "N",
       10,
       {{4, 1}, {8, 0}},
       "The bur was pressed too hard: let it cut.",
       {}},
      {"time_s", "Time", "s", 5, {{300, 1}, {900, 0}}, "The work took long.", {}},
  };
  return r;
}

std::string NameFor(const char* kind, const Scene& scene) {
  // 64 is all that a document takes as a name (json_read.h).
  return (std::string(kind) + "-" + scene.name).substr(0, 64);
}

Exercise ClassTwoExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("class-2", scene);
  e.title = "Class II cavity, mesial box";
  e.instructions =
      "Cut the mesial box: 3.2 mm wide, 3.5 mm deep from the marginal ridge, its axial wall 1 mm "
      "inside the middle of the ridge, open to the mesial side. Do not touch the neighbour.";
  e.target.landmark = "mesial_box";
  e.target.half_size_um = {990, 1'600, 0};
  e.target.depth_um = 3'500;
  // Less than elsewhere: on the mesial side the neighbour stands 0.05 mm away.
  e.target.leeway_side_um = 100;
  e.rubric.name = "class-2-mesial";
  // The mesial side is open: its points go to the axial wall.
  auto& criteria = e.rubric.criteria;
  for (RubricCriterion& c : criteria) {
    if (c.metric == "wall_distal_mm") c.title = "Axial wall", c.points *= 2;
  }
  std::erase_if(criteria, [](const RubricCriterion& c) { return c.metric == "wall_mesial_mm"; });
  return e;
}

// From the highest cusp to a little above the cervical line.
constexpr int32_t kCrownDepth_um = 6'500;

Exercise CrownExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("crown", scene);
  e.title = "Crown preparation";
  e.instructions =
      "Reduce the occlusal surface by 1.5 mm and the walls by 1 mm all around, down to a shoulder "
      "6.5 mm below the highest cusp. Neighbours and root stay untouched.";
  e.bur_shape = cutting::BurShape::kCone;  // "taper-16": leaves walls of 2 degrees
  e.bur_radius_um = 800;
  e.bur_length_um = 8'000;
  e.bur_narrow_radius_um = 500;
  e.target.landmark = "crown_top";
  // Wider than the widest built-in crown, 11 x 10.5 mm.
  e.target.half_size_um = {6'000, 6'000, 0};
  e.target.depth_um = kCrownDepth_um;
  e.rubric = ShapeRubric("crown-preparation");
  e.time_limit_s = 1'800;
  return e;
}

Exercise ShapeExercise(const Scene& scene, const Sha256& scene_hash, const Preparation& shape) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor(shape.name.c_str(), scene);
  e.title = "Practice: " + shape.title;
  e.instructions = shape.title + ", with upright walls and a flat floor.";
  CavityTarget box = BoundingTarget(shape);
  e.target.landmark = box.landmark;
  e.target.half_size_um = box.half_size_um;
  e.target.depth_um = box.depth_um;
  e.graded = false;
  e.touch_cues = kPracticeCues;
  e.rubric = ShapeRubric("practice-" + shape.name);
  return e;
}

}  // namespace

std::vector<Exercise> BuiltinExercises(const Scene& scene, const Sha256& scene_hash) {
  std::vector<Exercise> out;
  auto has = [&](const char* landmark) { return scene.landmarks.count(landmark) != 0; };
  // An incisor has no fossa to cut into.
  if (has("occlusal_centre") && scene.name != "incisor-11") {
    out.push_back(ClassOneExercise(scene, scene_hash));
  }
  if (has("mesial_box")) out.push_back(ClassTwoExercise(scene, scene_hash));
  if (has("crown_top")) out.push_back(CrownExercise(scene, scene_hash));
  for (const Preparation& p : scene.preparations) {
    if (has(p.name.c_str())) out.push_back(ShapeExercise(scene, scene_hash, p));
  }
  return out;
}

Exercise ClassOneExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e;
  e.name = ("class-1-" + scene.name).substr(0, 64);
  e.title = "Class I occlusal cavity";
  e.instructions =
      "Cut a box of 4.0 x 2.4 mm, 2.0 mm deep from the central fossa, with upright walls and a "
      "flat floor. "
      "No side may go more than 0.25 mm beyond. Do not expose the pulp.";
  e.scene = scene_hash;
  e.bur_shape = cutting::BurShape::kCylinder;
  e.bur_radius_um = 500;
  e.bur_length_um = 4'000;
  e.time_limit_s = 900;
  e.target.half_size_um = {2'000, 1'200, 0};
  e.target.depth_um = 2'000;
  e.target.leeway_side_um = 250;
  e.target.leeway_bottom_um = 250;
  e.target.container_um = 500;
  e.rubric = ClassOneRubric();
  return e;
}

}  // namespace enamel::scene
