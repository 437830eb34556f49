#include "common/scene/builtin/rubrics.h"

namespace enamel::scene {
namespace {

constexpr char kOurs[] = "chosen: no published figure";

RubricCritical Above(const char* error, const char* metric, const char* unit, double limit,
                     const char* source) {
  return {error, metric, unit, limit, true, source};
}
RubricCritical Below(const char* error, const char* metric, const char* unit, double limit,
                     const char* source) {
  return {error, metric, unit, limit, false, source};
}

}  // namespace

// A cavity in the wrong place is about once the task; a layer of 0.05 mm off a whole block is 1.4
// times one; a molar's crown is 25 times one.
std::vector<RubricCritical> CriticalOfAny() {
  return {Above("all_cut", "damage_percent", "%", 300, kOurs),
          Below("nothing_cut", "task_done_percent", "%", 5, kOurs)};
}

std::vector<RubricCritical> CriticalOfPulp() {
  return {Above("pulp_exposed", "pulp_exposed_mm2", "mm2", 0,
                "ADEX restorative criteria: an unwarranted exposure is a critical deficiency")};
}

std::vector<RubricCritical> CriticalOfCavity() {
  std::vector<RubricCritical> out = CriticalOfAny();
  // A cavity elsewhere has cut nothing of the task either; a lost crown is in no place.
  out.insert(out.begin() + 1,
             Below("wrong_place", "in_task_percent", "%", 40,
                   "chosen: examinations fail a wrong tooth or surface without a figure"));
  return out;
}

// Where sources differ, the milder: examinations fail an isthmus over half of the distance between
// the cusps, which some teeth reach when a wall is 0.4 mm too far; nobody passes 1.5 mm.
std::vector<RubricCritical> CriticalOfWidth(bool open_mesial) {
  std::vector<RubricCritical> out;
  for (const char* metric :
       {"wall_mesial_mm", "wall_distal_mm", "wall_buccal_mm", "wall_lingual_mm"}) {
    if (open_mesial && std::string_view(metric) == "wall_mesial_mm") continue;
    out.push_back(Above("gross_overextension", metric, "mm", 1.3,
                        "ADEX restorative criteria: isthmus over half of the distance between the "
                        "cusps; milder here"));
  }
  return out;
}

std::vector<RubricCritical> CriticalOfContact() {
  return {Above("contact_left", "contact_left_percent", "%", 25,
                "ADEX restorative criteria: a contact that is not visibly open"),
          Above("neighbour_damaged", "neighbour_depth_mm", "mm", 0.25,
                "ADEX restorative criteria: damage that needs a restoration; a shallower nick is "
                "polished out")};
}

// A crumb at the rim of the lesion is not what examiners fail.
std::vector<RubricCritical> CriticalOfCaries() {
  return {
      Above("caries_left_deep", "caries_left_percent", "%", 20,
            "ADEX restorative criteria: caries left at the enamel-dentin junction; the share is "
            "chosen")};
}

// Textbooks ask for at least 1 mm over the cusps and 0.5 mm at the walls of any crown
// (Shillingburg, Fundamentals of Fixed Prosthodontics); the milder: a third of the task.
std::vector<RubricCritical> CriticalOfCrown() {
  const char* const kLeast =
      "Shillingburg: at least 1 mm over the cusps and 0.5 mm at the walls; milder here";
  // Of the task: an incisor's edge is so thin that a height over it says little.
  return {Below("occlusal_untouched", "reduction_top_percent", "%", 33, kLeast),
          Below("all_cut", "stump_left_percent", "%", 40, kOurs),
          Below("one_axial_wall_untouched", "reduction_least_percent", "%", 33, kLeast),
          Above("finish_line_missing", "finish_missing_deg", "deg", 45,
                "chosen: an eighth of the way around"),
          Above("cannot_seat", "crown_overhang_mm", "mm", 0.15,
                "ADEX prosthodontic criteria: an undercut that prevents seating; less than the gap "
                "of a crown's cement and fit is tolerated")};
}

// A third as for a crown's walls.
std::vector<RubricCritical> CriticalOfFace() {
  return {Below("one_axial_wall_untouched", "side_done_least_percent", "%", 33, kOurs)};
}

void AddCritical(Rubric& rubric, const std::vector<RubricCritical>& critical) {
  rubric.critical.insert(rubric.critical.end(), critical.begin(), critical.end());
}

}  // namespace enamel::scene
