#include "station/lab/grades/expected_words.h"

#include <algorithm>

namespace enamel::station::lab {
namespace {

constexpr std::string_view kStop = "stop_earlier", kFurther = "cut_further";

// The first row that fits. A practice block and an access cavity have no criterion for each wall:
// their faults may be called a shape that is off, or a part that is not done.
const std::vector<ExpectedWords>& Table() {
  static const std::vector<ExpectedWords> table = {
      {{}, "critical: pulp_exposed", 0, {"pulp_exposed"}, {kStop}},
      {{}, "critical: nothing_cut", 0, {"nothing_cut"}, {kFurther}},
      {{}, "critical: all_cut", 0, {"all_cut"}, {kStop}},
      {{}, "critical: neighbour_damaged", 0, {"neighbour_damaged"}, {"do_guard"}},
      {{}, "critical: wrong_place", 0, {"wrong_place"}, {kStop}},
      {{}, "critical: occlusal_untouched", 0, {"occlusal_untouched"}, {kFurther}},
      {{}, "critical: one_axial_wall_untouched", 0, {"one_axial_wall_untouched"}, {kFurther}},
      {{}, "critical: finish_line_missing", 0, {"finish_line_missing"}, {"do_finish_all_around"}},
      {{}, "critical: cannot_seat", 0, {"cannot_seat"}, {"do_taper_more"}},
      {{}, "critical: contact_left", 0, {"contact_left"}, {kFurther}},
      {{}, "critical: caries_left_deep", 0, {"caries_left_deep"}, {kFurther}},
      {{}, "critical: gross_overextension", 0, {"gross_overextension"}, {kStop}},

      {{"crown"}, "convergence", 0, {"over_tapered"}, {"do_taper_less"}},
      {{"crown"}, "undercut", 0, {"undercut"}, {"do_taper_more"}},
      // Of a stump that is also 0.6 mm too slim all around.
      {{"crown"}, "lean", 0, {"preparation_leans", "off_target"}, {"do_align", kStop}},
      {{"crown"}, "finish_line", 1, {"finish_line_deep"}, {"do_finish_higher"}},
      {{"crown"}, "finish_line", -1, {"finish_line_high"}, {"do_finish_lower"}},
      {{"crown"}, "finish_waviness", 0, {"finish_line_uneven"}, {"do_finish_even"}},
      {{"crown"}, "walls_over", 0, {"over_reduced", "off_target"}, {kStop}},
      {{"crown"}, "walls_short", 0, {"under_reduced", "off_target", "unfinished"}, {kFurther}},
      {{"crown"}, "top_over", 0, {"over_reduced"}, {kStop}},
      {{"crown"}, "top_short", 0, {"under_reduced"}, {kFurther}},
      {{"veneer"}, "floor_over", 0, {"over_reduced", "too_deep", "off_target"}, {kStop}},
      {{"veneer"},
       "floor_short",
       0,
       {"under_reduced", "too_shallow", "off_target", "unfinished"},
       {kFurther}},
      {{"veneer"}, "tilt_floor", 0, {"off_target"}, {kStop, kFurther}},
      // Leans and waves leave as much as they take too much: either is to be said.
      {{"veneer"},
       "floor_waviness",
       0,
       {"floor_uneven", "off_target"},
       {"do_even_floor", kStop, kFurther}},

      {{}, "floor_waviness", 0, {"floor_uneven"}, {"do_even_floor"}},
      {{}, "waviness", 0, {"wall_wavy"}, {"do_even_wall"}},
      {{}, "walls_over", 0, {"over_extended", "off_target"}, {kStop}},
      {{}, "walls_short", 0, {"under_extended", "off_target", "unfinished"}, {kFurther}},
      {{}, "floor_over", 0, {"too_deep", "off_target"}, {kStop}},
      {{}, "floor_short", 0, {"too_shallow", "off_target", "unfinished"}, {kFurther}},
      {{"caries"}, "wall_", 1, {"sound_tissue_cut"}, {kStop}},
      {{"caries"}, "wall_", -1, {"caries_left"}, {kFurther}},
      {{"caries"}, "tilt_", 1, {"sound_tissue_cut"}, {kStop}},
      {{"caries"}, "taper", 0, {"sound_tissue_cut"}, {kStop}},
      {{"caries"}, "shift_", 0, {"sound_tissue_cut", "caries_left"}, {kStop, kFurther}},
      {{"caries"}, "turn", 0, {"sound_tissue_cut", "caries_left"}, {kStop, kFurther}},
      {{"caries"}, "floor", 1, {"sound_tissue_cut"}, {kStop}},
      {{"caries"}, "floor", -1, {"caries_left"}, {kFurther}},
      {{"caries"}, "pillar", 0, {"left_standing", "caries_left"}, {kFurther}},
      {{"caries"},
       "stopped early",
       0,
       {"caries_left", "caries_left_deep", "unfinished"},
       {kFurther}},
      {{"line"}, "wall_", 1, {"over_extended", "off_target"}, {kStop}},
      {{"line"}, "wall_", -1, {"under_extended", "off_target", "unfinished"}, {kFurther}},
      {{"line"},
       "shift_",
       0,
       {"over_extended", "under_extended", "off_target", "unfinished"},
       {kStop, kFurther}},
      {{"line"}, "turn", 0, {"over_extended", "off_target", "unfinished"}, {kStop, kFurther}},
      {{"line"}, "floor", 1, {"too_deep", "off_target"}, {kStop}},
      {{"line"}, "floor", -1, {"too_shallow", "off_target", "unfinished"}, {kFurther}},
      {{"line"}, "tilt_floor", 0, {"floor_slopes", "off_target"}, {"do_level", kStop, kFurther}},

      {{}, "wall_", 1, {"over_extended"}, {kStop}},
      {{}, "wall_", -1, {"under_extended"}, {kFurther}},
      {{}, "shift_", 0, {"over_extended", "under_extended"}, {kStop, kFurther}},
      {{}, "turn", 0, {"over_extended", "under_extended"}, {kStop, kFurther}},
      {{}, "tilt_floor", 0, {"floor_slopes"}, {"do_level"}},
      {{}, "tilt_", 0, {"walls_inclined", "over_tapered"}, {"do_parallel"}},
      {{"access"}, "undercut", 0, {"undercut", "walls_inclined"}, {"do_upright", "do_parallel"}},
      {{}, "taper", 0, {"walls_inclined", "over_tapered"}, {"do_parallel"}},
      {{}, "undercut", 0, {"undercut"}, {"do_upright"}},
      {{}, "floor", 1, {"too_deep"}, {kStop}},
      {{}, "floor", -1, {"too_shallow"}, {kFurther}},
      {{}, "all_over", 0, {"off_target", "too_deep", "over_extended", "over_reduced"}, {kStop}},
      {{},
       "all_short",
       0,
       {"off_target", "too_shallow", "under_extended", "under_reduced"},
       {kFurther}},
      {{}, "gouge", 0, {"gouge"}, {kStop}},
      {{}, "margin", 0, {"outline_wide", "over_extended"}, {kStop}},
      {{}, "pillar", 0, {"left_standing"}, {kFurther}},
      {{}, "left", 0, {"left_standing"}, {kFurther}},
      {{}, "caries left", 0, {"caries_left"}, {kFurther}},
      {{}, "nothing", 0, {"nothing_cut"}, {kFurther}},
      {{}, "everything removed", 0, {"all_cut"}, {kStop}},
      {{"crown", "veneer"},
       "stopped early",
       0,
       {"finish_line_missing", "one_axial_wall_untouched", "unfinished"},
       {kFurther, "do_finish_all_around"}},
      {{"class-2"},
       "stopped early",
       0,
       {"contact_left", "caries_left_deep", "unfinished"},
       {kFurther}},
      {{}, "stopped early", 0, {"unfinished", "off_target", "too_shallow"}, {kFurther}},
      {{}, "second hole", 0, {"cut_elsewhere"}, {kStop}},
      {{"veneer"}, "shaved", 0, {"cut_elsewhere", "outline_wide"}, {kStop}},
      {{"caries"}, "shaved", 0, {"cut_elsewhere", "sound_tissue_cut"}, {kStop}},
      // Of the neighbour too.
      {{"class-1-molar-46-class-2", "class-2", "crown-molar-46-class-2"},
       "shaved",
       0,
       {"cut_elsewhere", "neighbour_cut"},
       {kStop, "do_guard"}},
      {{}, "shaved", 0, {"cut_elsewhere"}, {kStop}},
      {{}, "neighbour cut", 0, {"neighbour_cut"}, {"do_guard"}},
  };
  return table;
}

// A fault that is critical besides is called by its error, and mended as that.
std::string_view NameOf(const GradeRow& row, std::string& kept) {
  const bool of_its_own = row.fault.starts_with("critical: ") || row.fault == "stopped early";
  if (row.critical_expected.empty() || of_its_own) return row.fault;
  return kept = "critical: " + row.critical_expected;
}

}  // namespace

const ExpectedWords* ExpectedWordsOf(const GradeRow& row) {
  if (row.points_lost < 1) return nullptr;
  std::string kept;
  const std::string_view fault = NameOf(row, kept);
  for (const ExpectedWords& e : Table()) {
    const bool of_exercise =
        e.exercises.empty() || std::ranges::any_of(e.exercises, [&](std::string_view name) {
          return row.exercise.starts_with(name);
        });
    if (of_exercise && fault.starts_with(e.fault) && (e.sign == 0 || e.sign * row.size > 0)) {
      return &e;
    }
  }
  return nullptr;
}

}  // namespace enamel::station::lab
