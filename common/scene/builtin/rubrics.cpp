#include "common/scene/builtin/rubrics.h"

#include <utility>

namespace enamel::scene {
namespace {

// Bands. A wall counts as right within 0.03 mm, which is over twice what the score itself errs by
// (a quarter of a voxel of 0.05 mm), loses a tenth at 0.1 mm and everything where the leeway ends.
// 0.1 mm is what an examiner's eye just sees: a minute of arc, normal sight, is 0.09 mm at 0.3 m.
// The shares are chosen, not measured on people: what holds them is the order of skill in
// grades_test.cpp, and that all surfaces of a cavity 0.08 mm off cost at most 3 points.
constexpr double kRight_mm = kRight_um * 1e-3, kSeen_mm = 0.1, kWrong_mm = kLeeway_um * 1e-3,
                 kSeenShare = 0.9;
// The same for a surface of which all is judged together.
constexpr double kFar_mm = 0.3;

// The accepted angles between opposite walls are those of the literature, 10 to 22 degrees
// (schemas/score.md, "Crown"), and less where the stump is tall enough to hold anyway. From buccal
// to lingual an incisor's edge is so thin that its walls are at 27 degrees.
RubricCriterion ConvergenceCriterion(const char* metric, const char* title, double most_deg) {
  return {metric,
          title,
          "deg",
          4,
          {{0, 0}, {5, 1}, {most_deg, 1}, {most_deg + 14, 0}},
          "Walls that taper too much do not hold the crown. Walls that are parallel or undercut do "
          "not let it seat.",
          {}};
}

}  // namespace

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

std::vector<RubricGate> TaskGates() {
  return {
      // All surfaces 0.08 mm short leave 82 to 88 % of a small cavity: nothing that was not done.
      // Below 78 % as if a line led from 5 to 90.
      {"task_done_percent",
       "Task done",
       "%",
       {{5, 0}, {78, 0.86}, {82, 1}},
       "Part of the task is not done."},
      {"damage_percent",
       "Cut outside the task",
       "%",
       {{20, 1}, {120, 0}},
       "Much was cut away that is not part of the task."},
      // Beside a large task a second hole is a small share of it.
      {"deepest_over_mm",
       "No second hole",
       "mm",
       {{0.6, 1}, {1.6, 0}},
       "At one spot, the bur cut its own width into what had to stay."}};
}

RubricCriterion PulpCriterion(double points) {
  return AtMost("pulp_exposed_mm2", "Pulp not exposed", "mm2", points, 0, 0.05,
                "The pulp was exposed: the whole attempt fails.");
}

RubricCriterion CoverCriterion(double points) {
  return AtLeast("remaining_dentin_mm", "Dentin over the pulp", "mm", points, 0.5, 0.9,
                 "Too little dentin is left over the pulp.");
}

RubricCriterion ElsewhereCriterion(double points) {
  return AtMost("outside_removed_mm3", "Nothing cut elsewhere", "mm3", points, 0.05, 1.5,
                "Sound tissue was cut away beyond the tolerance.");
}

// A wall that is 0.4 mm short leaves nothing of the kind; a pillar of 0.4 mm in a cavity 2 mm deep
// leaves 0.26 mm3, a lid of 0.1 mm over 3 mm2 of it 0.3.
RubricCriterion StandingCriterion(double points) {
  return AtMost("left_standing_mm3", "Nothing left inside", "mm3", points, 0.02, 0.3,
                "Part of what had to be removed was left uncut.");
}

void AddHand(Rubric& r, double force, double time, double full_s, double none_s) {
  r.criteria.push_back(AtMost("force_sent_p95_n", "Light hand", "N", force, 4, 8,
                              "The bur was pressed too hard: let it cut."));
  r.criteria.push_back(
      AtMost("time_s", "Time", "s", time, full_s, none_s, "The work took too long."));
}

Rubric ClassOneRubric(bool tooth) {
  Rubric r;
  r.name = "class-1-occlusal";
  r.gates = TaskGates();
  r.criteria = {
      AtLeast("task_done_percent", "Outline removed", "%", tooth ? 6 : 10, 70, 97,
              "Part of the outline was not removed."),
      StandingCriterion(8),
      ElsewhereCriterion(6),
      WallCriterion("wall_mesial_mm", "Mesial wall", 6,
                    "The mesial wall is not where it should be."),
      WallCriterion("wall_distal_mm", "Distal wall", 6,
                    "The distal wall is not where it should be."),
      WallCriterion("wall_buccal_mm", "Buccal wall", 6,
                    "The buccal wall is not where it should be."),
      WallCriterion("wall_lingual_mm", "Lingual wall", 6,
                    "The lingual wall is not where it should be."),
      WallCriterion(
          "floor_mm", tooth ? "Pulpal floor" : "Floor", tooth ? 8 : 11,
          "A deep floor weakens what is below it. A shallow one leaves the filling too thin."),
      AtMost("wall_tilt_deg", "Walls upright", "deg", 6, 2, 10, "A wall is tilted."),
      AtMost("undercut_deg", "No undercut", "deg", 6, 2, 8,
             "A wall is undercut: the filling could not be condensed beneath it."),
      AtMost("tilt_floor_deg", "Floor level", "deg", 3, 2, 10, "The floor slopes."),
      AtMost("wall_waviness_mm", "Walls smooth", "mm", 4, 0.025, 0.1, "A wall is wavy."),
      AtMost("floor_waviness_mm", "Floor flat", "mm", 3, 0.025, 0.1, "The floor is uneven."),
      // None from 0.3 mm: no wall may be that far off.
      AtMost("deepest_over_mm", "No gouge", "mm", 8, 0.1, 0.3,
             "At one spot, the bur cut deep beyond the outline: see the heat map."),
      AtMost("outline_over_mm", "Outline on the surface", "mm", 4, 0.1, 0.4,
             "The opening is wider than it should be."),
  };
  if (tooth) {
    r.criteria.push_back(PulpCriterion(4));
    r.criteria.push_back(CoverCriterion(3));
  }
  AddHand(r, 4, 3, 240, 600);
  r.critical = tooth ? CriticalOfCavity() : CriticalOfAny();
  if (tooth) {
    AddCritical(r, CriticalOfPulp());
    AddCritical(r, CriticalOfWidth(false));
    r.restoration = Restoration::kAmalgam;
    r.restorations = TolerancesOfCavity(false);
  }
  return r;
}

Rubric ShapeRubric(std::string name, double closeness, double nowhere, TimeBand time) {
  Rubric r;
  r.name = std::move(name);
  r.gates = TaskGates();
  r.criteria = {
      AtLeast("task_done_percent", "Shape fully cut", "%", 4, 70, 97,
              "Part of the shape was not removed."),
      StandingCriterion(6),
      {"deviation_rms_mm",
       "Closeness to the reference",
       "mm",
       closeness,
       {{kRight_mm, 1}, {kSeen_mm, kSeenShare}, {kFar_mm, 0}},
       "The surface is far from the reference.",
       {}},
      AtMost("deviation_p95_mm", "No spot far off", "mm", nowhere, 0.08, 0.6,
             "At one spot, the surface is far from the reference: see the heat map."),
      AtMost("deepest_over_mm", "No gouge", "mm", 10, 0.1, 0.4,
             "At one spot, the bur cut deep beyond the shape: see the heat map."),
      AtMost("most_left_mm", "Nothing left uncut", "mm", 10, 0.1, 0.6,
             "At one spot, much was left uncut: see the heat map."),
      AtMost("outside_removed_mm3", "Nothing cut beside or below", "mm3", 10, 0.05, 2,
             "Material beyond the tolerance was cut away."),
  };
  AddHand(r, 10, 5, time.full_s, time.none_s);
  r.critical = CriticalOfAny();
  return r;
}

RubricGate CariesGate() {
  return {"caries_left_percent",
          "Caries left",
          "%",
          {{10, 1}, {90, 0}},
          "Some caries was not removed."};
}

RubricCriterion NoCariesCriterion(double points) {
  // As far as where the gate begins: a criterion that ends before it tells 6 from 10 % by nothing.
  return AtMost("caries_left_percent", "No caries left", "%", points, 0.5, 10,
                "Caries was left: it would progress under the filling.");
}

Rubric CariesRubric() {
  Rubric r;
  r.name = "caries-excavation";
  r.gates = TaskGates();
  r.gates[0] = CariesGate();
  r.criteria = {
      NoCariesCriterion(32),
      StandingCriterion(10),
      AtMost("sound_removed_mm3", "Sound tissue preserved", "mm3", 17, 0.5, 6,
             "More sound tissue was removed than in the reference."),
      ElsewhereCriterion(8),
      AtMost("undercut_deg", "Walls not undercut", "deg", 5, 4, 12,
             "A wall is undercut: the filling could not be condensed beneath it."),
      AtMost("deepest_over_mm", "No gouge", "mm", 8, 0.1, 0.4,
             "At one spot, the bur cut deep into sound tissue: see the heat map."),
      PulpCriterion(5),
      CoverCriterion(5),
  };
  AddHand(r, 5, 5, 300, 900);
  r.critical = CriticalOfAny();
  AddCritical(r, CriticalOfPulp());
  AddCritical(r, CriticalOfCaries());
  return r;
}

Rubric CrownRubric(bool anterior) {
  Rubric r = ShapeRubric("crown-preparation", 8, 2, {1'200, 2'400});
  auto& criteria = r.criteria;
  // Exercises ask for 1.5 to 2 mm off the top, of which a fifth is 0.3 to 0.4 mm.
  criteria.push_back({"reduction_top_percent",
                      "Top reduced",
                      "%",
                      6,
                      {{70, 0}, {95, 1}, {105, 1}, {130, 0}},
                      "Too little taken off the top leaves the crown too thin. Too much leaves the "
                      "stump too low to hold it.",
                      {}});
  criteria.push_back(
      ConvergenceCriterion("convergence_mesiodistal_deg", "Convergence, mesial to distal", 22));
  criteria.push_back(ConvergenceCriterion("convergence_buccolingual_deg",
                                          "Convergence, buccal to lingual", anterior ? 30 : 22));
  // A molar's stump leans by 6.5 degrees, as its crown does.
  criteria.push_back(
      AtMost("crown_axis_deg", "Preparation upright", "deg", 3, 8, 18,
             "The preparation is tilted: the crown would have to seat at an angle."));
  criteria.push_back(AtMost("crown_undercut_mm2", "No undercut", "mm2", 6, 0.5, 4,
                            "A wall overhangs the finish line: the crown could not seat."));
  RubricCriterion line{"finish_depth_mm",
                       "Finish line at the right height",
                       "mm",
                       3,
                       {{-0.5, 0}, {-0.1, 1}, {0.1, 1}, {0.5, 0}},
                       "The finish line is not at the required height.",
                       {}};
  criteria.push_back(std::move(line));
  criteria.push_back(AtMost("finish_waviness_mm", "Finish line even", "mm", 3, 0.05, 0.25,
                            "The height of the finish line varies around the tooth."));
  criteria.push_back(PulpCriterion(3));
  criteria.push_back(CoverCriterion(3));
  // Where the crown is cut away, the pulp is open too.
  AddCritical(r, CriticalOfCrown());
  AddCritical(r, CriticalOfPulp());
  return r;
}

}  // namespace enamel::scene
