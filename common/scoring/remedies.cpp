#include "common/scoring/remedies.h"

#include <algorithm>
#include <iterator>

namespace enamel::scoring {
namespace {

constexpr Remedy kNone = {};

struct Row {
  std::string_view metric;
  Remedy above, below;
};

constexpr Remedy kWide = {"over_extended", kStopEarlier}, kNarrow = {"under_extended", kCutFurther};
constexpr Remedy kOpen = {"over_tapered", "do_parallel"}, kLeansIn = {"undercut", "do_upright"};
constexpr Remedy kOverReduced = {"over_reduced", kStopEarlier},
                 kUnderReduced = {"under_reduced", kCutFurther};
constexpr Remedy kOff = {"off_target", kWhereMost};
constexpr Remedy kBlunt = {"over_tapered", "do_taper_less"}, kSteep = {"undercut", "do_taper_more"};

constexpr Row kRows[] = {
    {"wall_mesial_mm", kWide, kNarrow},
    {"wall_distal_mm", kWide, kNarrow},
    {"wall_buccal_mm", kWide, kNarrow},
    {"wall_lingual_mm", kWide, kNarrow},
    {"floor_mm", {"too_deep", kStopEarlier}, {"too_shallow", kCutFurther}},
    {"tilt_mesial_deg", kOpen, kLeansIn},
    {"tilt_distal_deg", kOpen, kLeansIn},
    {"tilt_buccal_deg", kOpen, kLeansIn},
    {"tilt_lingual_deg", kOpen, kLeansIn},
    {"divergence_mesial_deg", kOpen, kLeansIn},
    {"divergence_distal_deg", kOpen, kLeansIn},
    {"divergence_buccal_deg", kOpen, kLeansIn},
    {"divergence_lingual_deg", kOpen, kLeansIn},
    {"tilt_floor_deg", {"floor_slopes", "do_level"}, kNone},
    // Below: a material that has to slide in needs walls that diverge more.
    {"wall_tilt_deg", {"walls_inclined", "do_parallel"}, {"walls_inclined", "do_diverge"}},
    {"undercut_deg", kLeansIn, kNone},
    {"wall_waviness_mm", {"wall_wavy", "do_even_wall"}, kNone},
    {"floor_waviness_mm", {"floor_uneven", "do_even_floor"}, kNone},
    {"outline_over_mm", {"outline_wide", kStopEarlier}, kNone},
    {"outline_short_mm", {"outline_short", kCutFurther}, kNone},
    {"cavosurface_off_deg", {"margin_angle", "do_margin"}, {"margin_angle", "do_margin"}},
    {"cavosurface_deg", {"margin_angle", "do_margin"}, {"margin_angle", "do_margin"}},
    {"line_angle_radius_mm", {"line_angle_dull", "do_sharpen"}, {"line_angle_sharp", "do_round"}},
    {"convergence_mesiodistal_deg", kBlunt, kSteep},
    {"convergence_buccolingual_deg", kBlunt, kSteep},
    {"convergence_least_deg", kNone, kSteep},
    {"convergence_most_deg", kBlunt, kNone},
    {"crown_axis_deg", {"preparation_leans", "do_align"}, kNone},
    {"crown_undercut_mm2", {"undercut", "do_taper_more"}, kNone},
    {"crown_overhang_mm", {"undercut", "do_taper_more"}, kNone},
    {"reduction_mesial_mm", kOverReduced, kUnderReduced},
    {"reduction_distal_mm", kOverReduced, kUnderReduced},
    {"reduction_buccal_mm", kOverReduced, kUnderReduced},
    {"reduction_lingual_mm", kOverReduced, kUnderReduced},
    {"reduction_top_mm", kOverReduced, kUnderReduced},
    {"reduction_top_least_mm", kOverReduced, kUnderReduced},
    {"reduction_top_percent", kOverReduced, kUnderReduced},
    {"reduction_least_percent", kNone, kUnderReduced},
    {"stump_left_percent", kNone, kOverReduced},
    {"finish_width_mm",
     {"finish_line_wide", "do_finish_narrower"},
     {"finish_line_narrow", "do_finish_wider"}},
    {"finish_width_least_mm", kNone, {"finish_line_narrow", "do_finish_wider"}},
    {"finish_depth_mm",
     {"finish_line_deep", "do_finish_higher"},
     {"finish_line_high", "do_finish_lower"}},
    {"finish_waviness_mm", {"finish_line_uneven", "do_finish_even"}, kNone},
    {"finish_complete_percent", kNone, {"finish_line_missing", "do_finish_all_around"}},
    {"finish_missing_deg", {"finish_line_missing", "do_finish_all_around"}, kNone},
    {"bevel_buccal_mm", {"bevel_wide", kStopEarlier}, {"bevel_narrow", "do_bevel"}},
    {"bevel_lingual_mm", {"bevel_wide", kStopEarlier}, {"bevel_narrow", "do_bevel"}},
    {"neighbour_removed_mm3", {"neighbour_cut", "do_guard"}, kNone},
    {"neighbour_depth_mm", {"neighbour_cut", "do_guard"}, kNone},
    {"force_sent_p95_n", {"heavy_hand", "do_lighter"}, kNone},
    {"force_sent_max_n", {"heavy_hand", "do_lighter"}, kNone},
    {"deviation_rms_mm", kOff, kNone},
    {"deviation_p95_mm", kOff, kNone},
    {"within_100um_percent", kNone, kOff},
    {"within_200um_percent", kNone, kOff},
    {"within_300um_percent", kNone, kOff},
    {"within_500um_percent", kNone, kOff},
    {"overlap_percent", kNone, kOff},
    {"deepest_over_mm", {"gouge", kStopEarlier}, kNone},
    {"most_left_mm", {"left_standing", kCutFurther}, kNone},
    {"task_done_percent", kNone, {"unfinished", kCutFurther}},
    {"missed_mm3", {"unfinished", kCutFurther}, kNone},
    {"side_done_least_percent", kNone, {"unfinished", kCutFurther}},
    {"contact_left_percent", {"left_standing", kCutFurther}, kNone},
    {"in_task_percent", kNone, {"cut_elsewhere", kStopEarlier}},
    {"left_standing_mm3", {"left_standing", kCutFurther}, kNone},
    {"zone_target_removed_percent", kNone, {"unfinished", kCutFurther}},
    {"caries_left_mm3", {"caries_left", kCutFurther}, kNone},
    {"caries_left_percent", {"caries_left", kCutFurther}, kNone},
    {"zone_leeway_removed_percent", {"over_extended", kStopEarlier}, kNone},
    {"zone_container_removed_mm3", {"cut_elsewhere", kStopEarlier}, kNone},
    {"overcut_mm3", {"over_extended", kStopEarlier}, kNone},
    {"outside_removed_mm3", {"cut_elsewhere", kStopEarlier}, kNone},
    {"damage_percent", {"cut_elsewhere", kStopEarlier}, kNone},
    {"sound_removed_mm3", {"sound_tissue_cut", kStopEarlier}, kNone},
    {"removed_pulp_mm3", {"pulp_exposed", kStopEarlier}, kNone},
    {"pulp_exposed_mm2", {"pulp_exposed", kStopEarlier}, kNone},
    {"remaining_dentin_mm", kNone, {"cover_thin", kStopEarlier}},
};

struct Text {
  std::string_view code, english;
};
constexpr Text kTexts[] = {
    {"do_align", "Hold the bur along the long axis of the tooth before you begin each wall"},
    {"do_bevel", "Lean the bur at 45 degrees and widen the bevel evenly along the cusps"},
    {"do_diverge", "Let the walls open toward the top by a few degrees, as a tapered bur does"},
    {"do_even_floor", "Finish the floor with light, overlapping strokes at one depth"},
    {"do_even_wall", "Finish the wall with long, light strokes from one end to the other"},
    {"do_finish_all_around", "Take the finish line around the whole tooth without a break"},
    {"do_finish_even", "Keep one distance to the gingiva, in one sweep around the tooth"},
    {"do_finish_higher", "End the cut earlier, at the height that was asked for"},
    {"do_finish_lower", "Take the finish line farther down, to the height that was asked for"},
    {"do_finish_narrower", "Sink the tip of the bur less deep into the tooth"},
    {"do_finish_wider", "Sink the tip of the bur deeper into the tooth, all around"},
    {"do_guard", "Leave a thin shell of enamel toward the adjacent tooth, and break it off last"},
    {"do_level", "Keep the end of the bur level while you finish the floor"},
    {"do_lighter", "Press less and let the bur cut"},
    {"do_margin", "Meet the surface of the tooth at a right angle along the margin"},
    {"do_parallel", "Hold the bur parallel to the long axis along the wall"},
    {"do_round", "Go along the line angles again with a rounded bur"},
    {"do_sharpen", "Finish the line angles with the corner of the bur"},
    {"do_taper_less",
     "Hold the bur parallel to the path of insertion and let its own taper shape the walls"},
    {"do_taper_more",
     "Lean the bur toward the middle of the tooth by a few degrees, and go around once more"},
    {"do_upright", "The wall leans in under the margin. Bring the bur upright"},
};

}  // namespace

const Remedy* FindRemedy(std::string_view metric, bool above) {
  const auto* row = std::ranges::find(kRows, metric, &Row::metric);
  if (row == std::end(kRows)) return nullptr;
  const Remedy& remedy = above ? row->above : row->below;
  return remedy.fault.empty() ? nullptr : &remedy;
}

std::vector<KnownFault> KnownFaults() {
  std::vector<KnownFault> out;
  for (const Row& row : kRows) {
    for (const Remedy& remedy : {row.above, row.below}) {
      if (remedy.fault.empty()) continue;
      auto known = std::ranges::find(out, remedy.fault, &KnownFault::fault);
      if (known == out.end()) known = out.insert(out.end(), {remedy.fault, {}});
      if (std::ranges::find(known->remedies, remedy.code) == known->remedies.end()) {
        known->remedies.push_back(remedy.code);
      }
    }
  }
  return out;
}

std::string_view RemedyText(std::string_view code) {
  const auto* text = std::ranges::find(kTexts, code, &Text::code);
  return text == std::end(kTexts) ? std::string_view() : text->english;
}

}  // namespace enamel::scoring
