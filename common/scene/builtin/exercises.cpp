#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>

#include "common/scene/builtin/builtin.h"
#include "common/scene/preparation.h"

namespace enamel::scene {
namespace {

using cutting::Tissue;

// Gentle: chatter like that of a handpiece held lightly, and an energy that moves no hand. 1 mW is
// what 0.1 N of chatter takes on the coarsest of the built-in devices (haptics/README.md).
constexpr TouchCueSpec kPracticeCues{250, 100, 200, 1'000};

// How far a side of a cavity may go beyond the line: what the text says, where the rubric's points
// for it end, and the zone that the page and the window show.
constexpr int32_t kLeeway_um = 250;

// Bands. A wall counts as right within 0.03 mm, which is over twice what the score itself errs by
// (a quarter of a voxel of 0.05 mm), loses a fifth at 0.1 mm and everything where the leeway ends.
// The first two are chosen, not measured on people: what holds them is the order of skill in
// grades_test.cpp.
constexpr int32_t kRight_um = 30;
constexpr double kRight_mm = kRight_um * 1e-3, kSeen_mm = 0.1, kWrong_mm = kLeeway_um * 1e-3,
                 kSeenShare = 0.8;

bool IsAnterior(const Scene& scene) { return scene.name.starts_with("incisor"); }

bool Has(const Scene& scene, cutting::Tissue tissue) {
  return std::any_of(scene.tissues.begin(), scene.tissues.end(),
                     [&](const TissueSpec& t) { return t.tissue == tissue; });
}

// A length as a student reads it: "1.5 mm".
std::string Mm(int32_t um) {
  std::string text = std::to_string(um / 1000) + "." + std::to_string(um / 100 % 10);
  if (um % 100 != 0) text += std::to_string(um / 10 % 10);
  return text + " mm";
}

RubricCriterion WallCriterion(const char* metric, const char* title, double points,
                              const char* comment) {
  RubricCriterion c{metric, title, "mm", points, {}, comment, {}};
  c.map = {{-kWrong_mm, 0}, {-kSeen_mm, kSeenShare}, {-kRight_mm, 1},
           {kRight_mm, 1},  {kSeen_mm, kSeenShare},  {kWrong_mm, 0}};
  return c;
}

RubricCriterion AtMost(const char* metric, const char* title, const char* unit, double points,
                       double full, double none, const char* comment) {
  return {metric, title, unit, points, {{full, 1}, {none, 0}}, comment, {}};
}

RubricCriterion AtLeast(const char* metric, const char* title, const char* unit, double points,
                        double none, double full, const char* comment) {
  return {metric, title, unit, points, {{none, 0}, {full, 1}}, comment, {}};
}

// A criterion earns only in so far as the task was done and the rest of the mouth is still there.
std::vector<RubricGate> TaskGates() {
  return {{"task_done_percent",
           "Task done",
           "%",
           {{5, 0}, {90, 1}},
           "The work was stopped early: part of the task is still to be cut."},
          {"damage_percent",
           "Cut where nothing was asked for",
           "%",
           {{20, 1}, {120, 0}},
           "Much was cut away that has nothing to do with the task."}};
}

RubricCriterion PulpCriterion(double points) {
  RubricCriterion c = AtMost("pulp_exposed_mm2", "Pulp not exposed", "mm2", points, 0, 0.05,
                             "The pulp was exposed: the whole attempt fails.");
  c.fails_above = 0.0;
  return c;
}

// Less than 0.5 mm of dentin is taken as too little to protect the pulp (schemas/score.md).
RubricCriterion CoverCriterion(double points) {
  return AtLeast("remaining_dentin_mm", "Cover of the pulp", "mm", points, 0.5, 0.9,
                 "Too little dentin is left over the pulp.");
}

RubricCriterion ElsewhereCriterion(double points) {
  return AtMost("outside_removed_mm3", "Nothing cut elsewhere", "mm3", points, 0.05, 1.5,
                "Sound tissue was cut away beyond the tolerance.");
}

void AddHand(Rubric& r, double force, double time, double full_s, double none_s) {
  r.criteria.push_back(AtMost("force_sent_p95_n", "Light hand", "N", force, 4, 8,
                              "The bur was pressed too hard: let it cut."));
  r.criteria.push_back(AtMost("time_s", "Time", "s", time, full_s, none_s, "The work took long."));
}

// `tooth`: there is a pulp to keep.
Rubric ClassOneRubric(bool tooth) {
  Rubric r;
  r.name = "class-1-occlusal";
  r.version = 3;
  r.gates = TaskGates();
  r.criteria = {
      AtLeast("task_done_percent", "Outline removed", "%", tooth ? 8 : 12, 70, 97,
              "Part of the outline was left standing."),
      ElsewhereCriterion(8),
      WallCriterion("wall_mesial_mm", "Mesial wall", 6,
                    "The mesial wall is not where it should be."),
      WallCriterion("wall_distal_mm", "Distal wall", 6,
                    "The distal wall is not where it should be."),
      WallCriterion("wall_buccal_mm", "Buccal wall", 6,
                    "The buccal wall is not where it should be."),
      WallCriterion("wall_lingual_mm", "Lingual wall", 6,
                    "The lingual wall is not where it should be."),
      WallCriterion("floor_mm", tooth ? "Pulpal floor" : "Floor", tooth ? 8 : 12,
                    "The floor is too deep or too shallow."),
      AtMost("wall_tilt_deg", "Walls upright", "deg", 6, 2, 10, "A wall leans."),
      AtMost("undercut_deg", "No undercut", "deg", 6, 2, 8,
             "A wall leans over the cavity: the filling could not be condensed under it."),
      AtMost("tilt_floor_deg", "Floor level", "deg", 4, 2, 10, "The floor slopes."),
      AtMost("wall_waviness_mm", "Walls smooth", "mm", 4, 0.025, 0.1, "A wall is wavy."),
      AtMost("floor_waviness_mm", "Floor flat", "mm", 3, 0.025, 0.1, "The floor is uneven."),
      // A gouge of 0.3 mm is gone through as far as a wall may not go at all.
      AtMost("deepest_over_mm", "No gouge", "mm", 8, 0.1, 0.3,
             "Somewhere the bur went deep beyond the outline: see the heat map."),
      AtMost("outline_over_mm", "Outline on the surface", "mm", 4, 0.1, 0.4,
             "The opening is wider than it should be."),
  };
  if (tooth) {
    r.criteria.push_back(PulpCriterion(4));
    r.criteria.push_back(CoverCriterion(4));
  }
  AddHand(r, 5, 4, 240, 600);
  return r;
}

// For shapes whose walls are not a box's: the distance to the reference says it all.
struct TimeBand {
  double full_s = 300, none_s = 900;
};
Rubric ShapeRubric(std::string name, double closeness = 30, double nowhere = 15,
                   TimeBand time = {}) {
  Rubric r;
  r.name = std::move(name);
  r.version = 3;
  r.gates = TaskGates();
  r.criteria = {
      AtLeast("task_done_percent", "All of it cut", "%", 10, 70, 97,
              "Part of the shape was left standing."),
      AtMost("deviation_rms_mm", "Closeness to the reference", "mm", closeness, kRight_mm, 0.3,
             "The surface is far from the reference."),
      AtMost("deviation_p95_mm", "Nowhere far off", "mm", nowhere, 0.08, 0.6,
             "Somewhere the surface is far from the reference: see the heat map."),
      AtMost("deepest_over_mm", "No gouge", "mm", 10, 0.1, 0.4,
             "Somewhere the bur went deep beyond the shape: see the heat map."),
      AtMost("most_left_mm", "Nothing left standing", "mm", 10, 0.1, 0.6,
             "Somewhere much was left standing: see the heat map."),
      AtMost("outside_removed_mm3", "Nothing beside and below cut", "mm3", 10, 0.05, 2,
             "Material beyond the tolerance was cut away."),
  };
  AddHand(r, 10, 5, time.full_s, time.none_s);
  return r;
}

// Caries goes, sound tissue stays, the pulp is kept covered. What has to go is what the reference
// took: the share of it that is left is judged, not how much was taken.
Rubric CariesRubric() {
  Rubric r;
  r.name = "caries-excavation";
  r.version = 2;
  r.gates = TaskGates();
  r.gates[0] = {"caries_left_percent",
                "Caries left",
                "%",
                {{10, 1}, {90, 0}},
                "The work was stopped early: there is still caries to be taken away."};
  r.criteria = {
      AtMost("caries_left_percent", "No caries left", "%", 35, 1, 12,
             "Caries was left: it goes on under the filling."),
      AtMost("sound_removed_mm3", "Sound tissue kept", "mm3", 20, 0.5, 6,
             "More sound tissue was taken than the reference took."),
      ElsewhereCriterion(10),
      AtMost("undercut_deg", "Walls not undercut", "deg", 5, 4, 12,
             "A wall leans over the cavity: the filling could not be condensed under it."),
      AtMost("deepest_over_mm", "No gouge", "mm", 10, 0.1, 0.4,
             "Somewhere the bur went deep into sound tissue: see the heat map."),
      PulpCriterion(5),
      CoverCriterion(5),
  };
  AddHand(r, 5, 5, 300, 900);
  return r;
}

std::string NameFor(const char* kind, const Scene& scene) {
  // 64 is all that a document takes as a name (json/read.h).
  return (std::string(kind) + "-" + scene.name).substr(0, 64);
}

Exercise ClassTwoExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("class-2", scene);
  e.title = "Class II cavity, mesial box";
  e.target.landmark = "mesial_box";
  e.target.half_size_um = {990, 1'600, 0};
  e.target.depth_um = 3'500;
  e.instructions = "Cut the mesial box: " + Mm(2 * e.target.half_size_um[1]) + " wide, " +
                   Mm(e.target.depth_um) + " deep from the marginal ridge, its axial wall " +
                   Mm(e.target.half_size_um[0]) +
                   " inside the middle of the ridge, open to the mesial side. Do not touch the "
                   "neighbour.";
  // Less than elsewhere: on the mesial side the neighbour stands 0.05 mm away.
  e.target.leeway_side_um = 100;
  e.rubric.name = "class-2-mesial";
  // The mesial side is open: its points, and the outline's, are for the neighbour.
  auto& criteria = e.rubric.criteria;
  for (RubricCriterion& c : criteria) {
    if (c.metric != "wall_distal_mm") continue;
    c.title = "Axial wall";
    c.comment = "The axial wall is not where it should be.";
  }
  std::erase_if(criteria, [](const RubricCriterion& c) {
    // The outline ends in the open side, where it has no place of its own.
    return c.metric == "wall_mesial_mm" || c.metric == "outline_over_mm";
  });
  // A nick can be polished out; a groove in the neighbour is caries to come.
  RubricCriterion neighbour = AtMost("neighbour_removed_mm3", "Neighbour untouched", "mm3", 10,
                                     0.001, 0.1, "The neighbouring tooth was cut.");
  neighbour.fails_above = 0.5;
  criteria.push_back(std::move(neighbour));
  return e;
}

Exercise CariesExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("caries", scene);
  e.title = "Caries excavation";
  e.instructions =
      "Open the lesion under the central fossa and take away all that is soft, and no more sound "
      "tissue than you must to reach it. Keep the pulp covered.";
  e.target.landmark = "caries";
  // The lesion's widest section and its bottom (FissureCaries in arrangement.h).
  e.target.half_size_um = {1'550, 1'150, 0};
  e.target.depth_um = 2'500;
  e.rubric = CariesRubric();
  return e;
}

// What a crown's preparation leaves of a tooth that is built in: as much off its walls and top as
// textbooks ask for (1 mm and 1.5 mm), less where the pulp would keep less than 0.9 mm of cover; the
// stump that the tooth's own sections give with that, its walls opened to 7 to 14 degrees where the
// sections would give less or more. Heights are below the landmark crown_top.
struct CrownTask {
  const char* tooth;  // the beginning of a scene's name
  int32_t depth_um;   // of the shoulder: above the cervical line
  int32_t off_top_um, off_walls_um;
  Stump::Section foot, table;
  int32_t corner_um;
};
constexpr CrownTask kCrowns[] = {{"molar-46",
                                  6'500,
                                  1'200,
                                  800,
                                  {{0, 250}, {4'100, 4'050}},
                                  {{50, -350}, {3'350, 3'050}},
                                  1'800},
                                 {"premolar-14",
                                  6'500,
                                  1'500,
                                  1'000,
                                  {{0, 50}, {1'900, 3'350}},
                                  {{-50, 150}, {1'150, 2'450}},
                                  700},
                                 {"incisor-11",
                                  9'000,
                                  1'500,
                                  1'000,
                                  {{0, 100}, {2'500, 2'300}},
                                  {{50, 400}, {2'100, 500}},
                                  450}};

const CrownTask* CrownOf(const Scene& scene) {
  const auto* it = std::find_if(std::begin(kCrowns), std::end(kCrowns), [&](const CrownTask& c) {
    return scene.name.starts_with(c.tooth);
  });
  return it == std::end(kCrowns) ? nullptr : it;
}

// Of a crown that is not built in nothing is known but its height: what has to go is what the
// reference took.
constexpr int32_t kUnknownCrownDepth_um = 6'500;

// The angles that are accepted between opposite walls are those of the literature, 10 to 22 degrees
// (schemas/score.md, "Crown"), and less where the stump is tall enough to hold anyway. From buccal to
// lingual an incisor's edge is so thin that its walls stand at 27 degrees.
RubricCriterion ConvergenceCriterion(const char* metric, const char* title, double most_deg) {
  return {metric,
          title,
          "deg",
          4,
          {{0, 0}, {5, 1}, {most_deg, 1}, {most_deg + 14, 0}},
          "Opposite walls stand too steep or too flat to each other.",
          {}};
}

Rubric CrownRubric(bool anterior) {
  Rubric r = ShapeRubric("crown-preparation", 15, 4, {1'200, 2'400});
  r.version = 4;
  auto& criteria = r.criteria;
  criteria.push_back(
      ConvergenceCriterion("convergence_mesiodistal_deg", "Convergence, mesial to distal", 22));
  criteria.push_back(ConvergenceCriterion("convergence_buccolingual_deg",
                                          "Convergence, buccal to lingual", anterior ? 30 : 22));
  // A molar's stump leans by 6.5 degrees, as its crown does.
  criteria.push_back(AtMost("crown_axis_deg", "Stump upright", "deg", 3, 8, 18,
                            "The stump leans: the crown would have to go on at an angle."));
  criteria.push_back(AtMost("crown_undercut_mm2", "No undercut", "mm2", 3, 0.5, 4,
                            "A wall leans out over the finish line: the crown could not seat."));
  RubricCriterion line{"finish_depth_mm",
                       "Finish line at its height",
                       "mm",
                       3,
                       {{-0.5, 0}, {-0.1, 1}, {0.1, 1}, {0.5, 0}},
                       "The finish line is not at the height that is asked for.",
                       {}};
  criteria.push_back(std::move(line));
  criteria.push_back(AtMost("finish_waviness_mm", "Finish line even", "mm", 3, 0.05, 0.25,
                            "The finish line goes up and down around the stump."));
  criteria.push_back(PulpCriterion(3));
  criteria.push_back(CoverCriterion(3));
  return r;
}

Exercise CrownExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("crown", scene);
  e.title = "Crown preparation";
  e.bur_shape = cutting::BurShape::kCone;  // "taper-16"
  e.bur_radius_um = 800;
  e.bur_length_um = 8'000;
  e.bur_narrow_radius_um = 500;
  e.target.landmark = "crown_top";
  // Wider than the widest built-in crown, 11 x 10.5 mm.
  e.target.half_size_um = {6'000, 6'000, 0};
  e.target.depth_um = kUnknownCrownDepth_um;
  const CrownTask* crown = CrownOf(scene);
  const bool anterior = IsAnterior(scene);
  const std::string top = anterior ? "incisal edge" : "occlusal surface";
  const std::string highest = anterior ? "the incisal edge" : "the highest cusp";
  if (crown == nullptr) {
    e.instructions = "Reduce the " + top +
                     " and the walls all around as the reference does, down to a shoulder " +
                     Mm(e.target.depth_um) + " below " + highest + ".";
  } else {
    e.target.depth_um = crown->depth_um;
    PreparationPart part;
    part.outline = PreparationPart::Outline::kStump;
    part.half_size_um = {e.target.half_size_um[0], e.target.half_size_um[1]};
    part.depth_um = crown->depth_um;
    part.stump = {crown->foot, crown->table, crown->off_top_um, crown->corner_um};
    e.target.parts = {part};
    // The top is flat: where a fissure lies deeper nothing is taken.
    const std::string take_top = anterior ? "Take the incisal edge down by " + Mm(crown->off_top_um)
                                          : "Take the cusps down to a flat top " +
                                                Mm(crown->off_top_um) + " below the highest one";
    e.instructions = take_top + ". Reduce the walls by at least " + Mm(crown->off_walls_um) +
                     " all around, down to a shoulder " + Mm(crown->depth_um) + " below " +
                     highest + ".";
  }
  e.instructions += Has(scene, Tissue::kNeighbour) ? " Neighbours and root stay untouched."
                                                   : " The root stays untouched.";
  e.time_limit_s = 1'800;
  // A simulated good hand takes a quarter of an hour.
  e.rubric = CrownRubric(anterior);
  return e;
}

// Through the roof of a molar's pulp chamber and down to half its height, as wide as the chamber is
// there (teeth.cpp, 2.5 x 1.7 mm half, its middle 4 mm below the fossa): so that no roof is left to
// hide a canal, and the floor, 1.1 mm lower, is not touched.
constexpr std::array<std::array<int32_t, 2>, 8> kAccessOutline = {{{2'000, -800},
                                                                   {2'000, 800},
                                                                   {1'000, 1'450},
                                                                   {-1'000, 1'450},
                                                                   {-2'000, 800},
                                                                   {-2'000, -800},
                                                                   {-1'000, -1'450},
                                                                   {1'000, -1'450}}};
constexpr int32_t kAccessDepth_um = 4'000;

bool HasKnownChamber(const Scene& scene) { return scene.name == "molar-46"; }

Exercise AccessExercise(const Scene& scene, const Sha256& scene_hash) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("access", scene);
  e.title = "Access cavity";
  PreparationPart part;
  part.outline = PreparationPart::Outline::kPolygon;
  part.corners_um.assign(kAccessOutline.begin(), kAccessOutline.end());
  part.depth_um = kAccessDepth_um;
  e.target.half_size_um = {2'000, 1'450, 0};
  e.target.depth_um = kAccessDepth_um;
  e.target.parts = {part};
  e.instructions = "Open the pulp chamber from the central fossa: take its whole roof away, " +
                   Mm(2 * e.target.half_size_um[0]) + " x " + Mm(2 * e.target.half_size_um[1]) +
                   ", with upright walls, " + Mm(kAccessDepth_um) +
                   " deep. Do not touch the chamber's floor.";
  e.rubric = ShapeRubric("access-cavity", 30, 10);
  e.rubric.criteria[0].title = "Roof removed";
  e.rubric.criteria[0].comment = "Part of the chamber's roof was left standing.";
  e.rubric.criteria.push_back(
      AtMost("wall_tilt_deg", "Walls upright", "deg", 5, 3, 12, "A wall leans."));
  return e;
}

Exercise ShapeExercise(const Scene& scene, const Sha256& scene_hash, const Preparation& shape) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor(shape.name.c_str(), scene);
  e.title = "Practice: " + shape.title;
  e.instructions = shape.title + ", with upright walls and a flat floor.";
  CavityTarget target = TargetFor(shape);
  target.leeway_side_um = e.target.leeway_side_um;
  target.leeway_bottom_um = e.target.leeway_bottom_um;
  target.container_um = e.target.container_um;
  e.target = std::move(target);
  e.graded = false;
  e.touch_cues = kPracticeCues;
  e.rubric = ShapeRubric("practice-" + shape.name);
  return e;
}

}  // namespace

Exercise PreparedExercise(const Scene& scene, const Sha256& scene_hash,
                          const CavityTarget& target) {
  Exercise e = ClassOneExercise(scene, scene_hash);
  e.name = NameFor("prepared", scene);
  e.title = "Preparation after an example";
  e.instructions = "Prepare the tooth as the example is prepared: what is marked goes, and " +
                   std::string(Has(scene, Tissue::kNeighbour) ? "neighbours and " : "") +
                   "the rest of the tooth stay. A place that is at most " + Mm(kRight_um) +
                   " off is right, and " + Mm(target.leeway_side_um) +
                   " beyond it tissue that should stay begins.";
  e.target = target;
  e.time_limit_s = 1'800;
  e.rubric = ShapeRubric("prepared-tooth", 25, 10, {1'200, 2'400});
  auto& criteria = e.rubric.criteria;
  criteria[1].title = "Closeness to the example";
  criteria[1].comment = "The surface is far from the example's.";
  const bool tooth = Has(scene, Tissue::kPulp);
  criteria.push_back(AtMost("undercut_deg", "No undercut", "deg", tooth ? 4 : 10, 2, 8,
                            "A wall leans over the cavity more than the example's."));
  if (tooth) {
    criteria.push_back(PulpCriterion(3));
    criteria.push_back(CoverCriterion(3));
  }
  return e;
}

std::vector<Exercise> BuiltinExercises(const Scene& scene, const Sha256& scene_hash) {
  std::vector<Exercise> out;
  auto has = [&](const char* landmark) { return scene.landmarks.count(landmark) != 0; };
  // An incisor has no fossa to cut into.
  if (has("occlusal_centre") && !IsAnterior(scene)) {
    out.push_back(ClassOneExercise(scene, scene_hash));
  }
  if (has("occlusal_centre") && HasKnownChamber(scene)) {
    out.push_back(AccessExercise(scene, scene_hash));
  }
  if (has("caries")) out.push_back(CariesExercise(scene, scene_hash));
  if (has("mesial_box")) out.push_back(ClassTwoExercise(scene, scene_hash));
  if (has("crown_top")) out.push_back(CrownExercise(scene, scene_hash));
  for (const Preparation& p : scene.preparations) {
    if (has(p.name.c_str())) out.push_back(ShapeExercise(scene, scene_hash, p));
  }
  return out;
}

Exercise ClassOneExercise(const Scene& scene, const Sha256& scene_hash) {
  const bool tooth = Has(scene, Tissue::kPulp);
  Exercise e;
  e.name = ("class-1-" + scene.name).substr(0, 64);
  e.title = tooth ? "Class I occlusal cavity" : "Box in the middle, as of a class I cavity";
  e.scene = scene_hash;
  e.bur_shape = cutting::BurShape::kCylinder;
  e.bur_radius_um = 500;
  e.bur_length_um = 4'000;
  e.time_limit_s = 900;
  e.target.half_size_um = {2'000, 1'200, 0};
  // Or its ends would stand in the marginal ridges, 5.2 mm apart.
  if (scene.name.starts_with("premolar")) e.target.half_size_um = {1'600, 1'100, 0};
  e.target.depth_um = 2'000;
  e.target.leeway_side_um = kLeeway_um;
  e.target.leeway_bottom_um = kLeeway_um;
  e.target.container_um = 500;
  e.instructions = "Cut a box of " + Mm(2 * e.target.half_size_um[0]) + " x " +
                   Mm(2 * e.target.half_size_um[1]) + ", " + Mm(e.target.depth_um) +
                   (tooth ? " deep from the central fossa" : " deep from the middle of the top") +
                   ", with upright walls and a flat floor. A side that is at most " +
                   Mm(kRight_um) + " off has full marks, one that is " + Mm(kLeeway_um) +
                   " off has none." + (tooth ? " Do not expose the pulp." : "");
  e.rubric = ClassOneRubric(tooth);
  return e;
}

}  // namespace enamel::scene
