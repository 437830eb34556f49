#include <algorithm>
#include <cmath>
#include <string>

#include "common/scoring/measured.h"

namespace enamel::scoring {
namespace {

using cutting::Tissue;

constexpr double kMm = 1e3, kMm2 = 1e6, kMm3 = 1e9;

double Percent(double part, double whole) { return whole > 0 ? 100 * part / whole : 0; }
double Of(const TissueVolumes_m3& v, Tissue t) { return v[static_cast<size_t>(t)]; }
double Removed(const Measured& m, Tissue t) { return Of(m.removed, t) * kMm3; }

// Whether a metric has a value here.
using State = std::optional<NoValue>;
State Always(const Measured&) { return {}; }
State Unless(bool in_task) { return in_task ? State{} : NoValue::kNotInTask; }
State WithCaries(const Measured& m) { return Unless(Of(m.task.task, Tissue::kCaries) > 0); }
State WithNeighbour(const Measured& m) { return Unless(m.has_neighbour); }
State WithPulp(const Measured& m) { return Unless(m.has_pulp); }
State WithOutline(const Measured& m) { return Unless(m.outline.in_task); }
template <Part kPart, bool WallFigures::*kThere>
State OfWall(const Measured& m) {
  if (!m.walls[kPart].in_task) return NoValue::kNotInTask;
  return m.walls[kPart].*kThere ? State{} : NoValue::kNotMade;
}
template <Part kPart>
constexpr auto WithWall = OfWall<kPart, &WallFigures::begun>;
template <Part kPart>
constexpr auto WithMadeWall = OfWall<kPart, &WallFigures::made>;
State WithUprightWalls(const Measured& m) {
  bool any = false;
  for (size_t p = 0; p < kFloor; ++p) {
    if (!m.walls[p].in_task) continue;
    if (!m.walls[p].made) return NoValue::kNotMade;
    any = true;
  }
  return Unless(any);
}
State IfMade(const std::optional<double>& value) { return value ? State{} : NoValue::kNotMade; }
template <BevelFigures CrownFigures::*kBevel>
State WithBevel(const Measured& m) {
  if (!m.crown.in_task) return NoValue::kNotInTask;
  return m.crown.made && (m.crown.*kBevel).made ? State{} : NoValue::kNotMade;
}
template <auto kFigures>
State WithMade(const Measured& m) {
  if (!(m.*kFigures).in_task) return NoValue::kNotInTask;
  return (m.*kFigures).made ? State{} : NoValue::kNotMade;
}
State WithCut(const Measured& m) { return IfMade(m.process->angulation_mean_deg()); }
template <Tissue kTissue>
State WithRemoved(const Measured& m) {
  if (!(Of(m.task.task, kTissue) > 0)) return NoValue::kNotInTask;
  return IfMade(m.process->half_removed_s(kTissue));
}
template <Tissue kTissue>
double Half_s(const Measured& m) {
  return *m.process->half_removed_s(kTissue);
}
template <Tissue kTissue>
double RemovalRate(const Measured& m) {
  return m.process->cutting_s() > 0 ? Removed(m, kTissue) / m.process->cutting_s() : 0;
}
// The largest over the walls that are in the task.
template <typename F>
double WorstWall(const Measured& m, F&& of) {
  double worst = 0;
  for (size_t p = 0; p < kFloor; ++p) {
    if (m.walls[p].in_task && m.walls[p].made) worst = std::max(worst, of(m.walls[p]));
  }
  return worst;
}

using enum MetricGroup;
using AtLimit = MetricInfo::AtLimit;

// A table and not a switch: what is measured, shown and named in a rubric is the same list.
struct Entry {
  MetricGroup group;
  MetricInfo info;
  double (*value)(const Measured&);
  State (*state)(const Measured&) = Always;
};

// Formulas in full, with sources: schemas/score.md.
constexpr Entry kRegistry[] = {
    {kZones,
     {"zone_target_removed_percent", "%", "Target removed",
      "Share of the solid inside the target box that went."},
     [](const Measured& m) { return Percent(m.target.removed_m3, m.target.solid_m3); }},
    {kZones,
     {"zone_leeway_removed_percent", "%", "Leeway removed",
      "Share of the solid between target and leeway box that went."},
     [](const Measured& m) {
       return Percent(m.leeway.removed_m3 - m.target.removed_m3,
                      m.leeway.solid_m3 - m.target.solid_m3);
     }},
    {kZones,
     {"zone_container_removed_mm3", "mm3", "Container removed",
      "Volume that went between leeway and container box, which must stay."},
     [](const Measured& m) {
       // Where nothing went, rounding of two sums must not say less than nothing.
       return std::max(0.0, m.container.removed_m3 - m.leeway.removed_m3) * kMm3;
     }},
    {kDeviation,
     {"deviation_rms_mm", "mm", "Deviation from the reference",
      "Root mean square distance of the attempt's surface from the reference's cut, by area."},
     [](const Measured& m) { return m.deviation.rms_m * kMm; }},
    {kDeviation,
     {"deviation_p95_mm", "mm", "Largest deviations",
      "Distance that 95 % of the reference's cut surface stays within of the attempt's."},
     [](const Measured& m) { return m.deviation.p95_m * kMm; }},
    {kDeviation,
     {"within_100um_percent", "%", "Within 0.1 mm of the reference",
      "Share of the reference's cut surface that is no farther than 0.1 mm from the attempt's."},
     [](const Measured& m) { return 100 * m.deviation.within[0]; }},
    {kDeviation,
     {"within_200um_percent", "%", "Within 0.2 mm of the reference", "The same for 0.2 mm."},
     [](const Measured& m) { return 100 * m.deviation.within[1]; }},
    {kDeviation,
     {"within_300um_percent", "%", "Within 0.3 mm of the reference", "The same for 0.3 mm."},
     [](const Measured& m) { return 100 * m.deviation.within[2]; }},
    {kDeviation,
     {"within_500um_percent", "%", "Within 0.5 mm of the reference", "The same for 0.5 mm."},
     [](const Measured& m) { return 100 * m.deviation.within[3]; }},
    {kDeviation,
     {"deepest_over_mm", "mm", "Deepest place beyond the reference",
      "At least 0.02 mm2 of the cut lies so deep under the reference's surface."},
     [](const Measured& m) { return m.deepest_over.depth_m * kMm; }},
    {kDeviation,
     {"most_left_mm", "mm", "Most left standing",
      "At least 0.02 mm2 of the reference's cut lies so deep under the attempt's surface."},
     [](const Measured& m) { return m.deviation.most_left_m * kMm; }},
    {kWalls,
     {"wall_mesial_mm", "mm", "Mesial wall", "Median signed deviation of the mesial wall, by area.",
      "too deep", "short"},
     [](const Measured& m) { return m.walls[kMesial].offset_m * kMm; },
     WithWall<kMesial>},
    {kWalls,
     {"wall_distal_mm", "mm", "Distal wall", "Median signed deviation of the distal wall, by area.",
      "too deep", "short"},
     [](const Measured& m) { return m.walls[kDistal].offset_m * kMm; },
     WithWall<kDistal>},
    {kWalls,
     {"wall_buccal_mm", "mm", "Buccal wall", "Median signed deviation of the buccal wall, by area.",
      "too deep", "short"},
     [](const Measured& m) { return m.walls[kBuccal].offset_m * kMm; },
     WithWall<kBuccal>},
    {kWalls,
     {"wall_lingual_mm", "mm", "Lingual wall",
      "Median signed deviation of the lingual wall, by area.", "too deep", "short"},
     [](const Measured& m) { return m.walls[kLingual].offset_m * kMm; },
     WithWall<kLingual>},
    {kWalls,
     {"floor_mm", "mm", "Floor", "Median signed deviation of the cavity's floor, by area.",
      "too deep", "too shallow"},
     [](const Measured& m) { return m.walls[kFloor].offset_m * kMm; },
     WithWall<kFloor>},
    {kWalls,
     {"tilt_mesial_deg", "deg", "Mesial wall, tilt",
      "Angle of the mesial wall against the reference's, by a plane through it.",
      "more open at the top", "undercut"},
     [](const Measured& m) { return m.walls[kMesial].tilt_deg; },
     WithMadeWall<kMesial>},
    {kWalls,
     {"tilt_distal_deg", "deg", "Distal wall, tilt",
      "Angle of the distal wall against the reference's, by a plane through it.",
      "more open at the top", "undercut"},
     [](const Measured& m) { return m.walls[kDistal].tilt_deg; },
     WithMadeWall<kDistal>},
    {kWalls,
     {"tilt_buccal_deg", "deg", "Buccal wall, tilt",
      "Angle of the buccal wall against the reference's, by a plane through it.",
      "more open at the top", "undercut"},
     [](const Measured& m) { return m.walls[kBuccal].tilt_deg; },
     WithMadeWall<kBuccal>},
    {kWalls,
     {"tilt_lingual_deg", "deg", "Lingual wall, tilt",
      "Angle of the lingual wall against the reference's, by a plane through it.",
      "more open at the top", "undercut"},
     [](const Measured& m) { return m.walls[kLingual].tilt_deg; },
     WithMadeWall<kLingual>},
    {kWalls,
     {"tilt_floor_deg", "deg", "Floor, tilt",
      "Angle of the floor against the reference's, by a plane through it."},
     [](const Measured& m) { return m.walls[kFloor].tilt_deg; },
     WithMadeWall<kFloor>},
    {kWalls,
     {"wall_tilt_deg", "deg", "Slope of the walls",
      "Largest angle of any wall against the reference's, whichever way."},
     [](const Measured& m) {
       return WorstWall(m, [](const WallFigures& w) { return std::fabs(w.tilt_deg); });
     },
     WithUprightWalls},
    {kWalls,
     {"undercut_deg", "deg", "Undercut",
      "Largest angle by which a wall leans over the cavity, against the vertical."},
     [](const Measured& m) {
       return WorstWall(m, [](const WallFigures& w) { return -w.opens_deg; });
     },
     WithUprightWalls},
    {kWalls,
     {"wall_waviness_mm", "mm", "Waviness of the walls",
      "Largest root mean square height of a wall about its own plane, against the reference's."},
     [](const Measured& m) {
       return WorstWall(m, [](const WallFigures& w) { return w.waviness_m; }) * kMm;
     },
     WithUprightWalls},
    {kWalls,
     {"floor_waviness_mm", "mm", "Waviness of the floor",
      "Root mean square height of the floor about its own plane, against the reference's."},
     [](const Measured& m) { return m.walls[kFloor].waviness_m * kMm; },
     WithMadeWall<kFloor>},
    {kOutline,
     {"outline_over_mm", "mm", "Outline too wide",
      "How far 95 % of the outline on the tooth stays within beyond the reference's."},
     [](const Measured& m) { return m.outline.over_m * kMm; },
     WithOutline},
    {kOutline,
     {"outline_short_mm", "mm", "Outline short",
      "How far 95 % of the outline on the tooth stays within short of the reference's."},
     [](const Measured& m) { return m.outline.short_m * kMm; },
     WithOutline},
    {kCrown,
     {"convergence_mesiodistal_deg", "deg", "Convergence, mesial to distal",
      "Angle between the mesial and the distal wall of the stump."},
     [](const Measured& m) { return m.crown.mesiodistal_deg; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"convergence_buccolingual_deg", "deg", "Convergence, buccal to lingual",
      "Angle between the buccal and the lingual wall of the stump."},
     [](const Measured& m) { return m.crown.buccolingual_deg; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"convergence_least_deg", "deg", "Least convergence",
      "Least angle between opposite walls of the stump in eight sections; below 0 none can seat."},
     [](const Measured& m) { return m.crown.least_deg; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"convergence_most_deg", "deg", "Most convergence",
      "Largest angle between opposite walls of the stump in eight sections."},
     [](const Measured& m) { return m.crown.most_deg; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"crown_axis_deg", "deg", "Lean of the stump",
      "Angle of the middle line between the walls against the tooth's axis."},
     [](const Measured& m) { return m.crown.axis_deg; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"crown_undercut_mm2", "mm2", "Undercut of the stump",
      "Area of the stump's walls that leans out over the finish line by more than 2 degrees."},
     [](const Measured& m) { return m.crown.undercut_m2 * kMm2; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"reduction_mesial_mm", "mm", "Taken off mesially", "Median over the mesial wall's height."},
     [](const Measured& m) { return m.crown.wall_m[kMesial] * kMm; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"reduction_distal_mm", "mm", "Taken off distally", "Median over the distal wall's height."},
     [](const Measured& m) { return m.crown.wall_m[kDistal] * kMm; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"reduction_buccal_mm", "mm", "Taken off buccally", "Median over the buccal wall's height."},
     [](const Measured& m) { return m.crown.wall_m[kBuccal] * kMm; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"reduction_lingual_mm", "mm", "Taken off lingually",
      "Median over the lingual wall's height."},
     [](const Measured& m) { return m.crown.wall_m[kLingual] * kMm; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"reduction_top_mm", "mm", "Taken off the top", "Median height taken off the stump's top."},
     [](const Measured& m) { return m.crown.top_m * kMm; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"reduction_top_least_mm", "mm", "Least taken off the top",
      "Height that 95 % of the stump's top had taken off at least."},
     [](const Measured& m) { return m.crown.top_least_m * kMm; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"finish_width_mm", "mm", "Width of the finish line", "Median of 72 places around the stump."},
     [](const Measured& m) { return m.crown.width_m * kMm; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"finish_width_least_mm", "mm", "Least width of the finish line",
      "Width that 95 % of the places around the stump have at least."},
     [](const Measured& m) { return m.crown.width_least_m * kMm; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"finish_depth_mm", "mm", "Height of the finish line",
      "Median distance below the reference's finish line.", "too deep", "too high"},
     [](const Measured& m) { return m.crown.depth_m * kMm; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"finish_waviness_mm", "mm", "Waviness of the finish line",
      "Root mean square height of the finish line about its own middle, against the reference's."},
     [](const Measured& m) { return m.crown.waviness_m * kMm; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"finish_complete_percent", "%", "Finish line all around",
      "Share of the places around the stump with a finish line of at least 0.3 mm."},
     [](const Measured& m) { return 100 * m.crown.complete; },
     WithMade<&Measured::crown>},
    {kCrown,
     {"bevel_buccal_mm", "mm", "Bevel of the buccal cusps",
      "Median width of what falls outwards at 30 to 65 degrees over the buccal wall."},
     [](const Measured& m) { return m.crown.bevel_buccal.width_m * kMm; },
     WithBevel<&CrownFigures::bevel_buccal>},
    {kCrown,
     {"bevel_lingual_mm", "mm", "Bevel of the lingual cusps",
      "Median width of what falls outwards at 30 to 65 degrees over the lingual wall."},
     [](const Measured& m) { return m.crown.bevel_lingual.width_m * kMm; },
     WithBevel<&CrownFigures::bevel_lingual>},
    {kLineAngles,
     {"line_angle_radius_mm", "mm", "Radius of the line angles",
      "Median radius of the round between the floor and the walls."},
     [](const Measured& m) { return m.line_angles.radius_m * kMm; },
     WithMade<&Measured::line_angles>},
    {kMargin,
     {"cavosurface_deg", "deg", "Angle of the margin",
      "Median angle through the tooth between its surface and the wall, along the outline."},
     [](const Measured& m) { return m.margin.angle_deg; },
     WithMade<&Measured::margin>},
    {kMargin,
     {"cavosurface_off_deg", "deg", "Margin off the reference's",
      "Angle that 95 % of the outline's margin is no farther from the reference's own."},
     [](const Measured& m) { return m.margin.worst_deg; },
     WithMade<&Measured::margin>},
    {kTask,
     {"task_done_percent", "%", "Task done",
      "Share of what the reference took away that the attempt took away too."},
     [](const Measured& m) { return Percent(m.task.done_m3(), m.task.task_m3()); }},
    {kTask,
     {"overlap_percent", "%", "Overlap with the reference",
      "Dice coefficient of the volumes that attempt and reference took away."},
     [](const Measured& m) {
       return Percent(2 * m.task.done_m3(), m.task.task_m3() + Sum_m3(m.removed));
     }},
    {kTask,
     {"missed_mm3", "mm3", "Left of the task",
      "Volume that the reference took away and the attempt left."},
     [](const Measured& m) { return Sum_m3(m.task.missed) * kMm3; }},
    {kTask,
     {"left_standing_mm3", "mm3", "Left standing",
      "Of what the reference took away, what the attempt left farther than 0.4 mm from its cut."},
     [](const Measured& m) { return Sum_m3(m.task.standing) * kMm3; }},
    {kTask,
     {"overcut_mm3", "mm3", "Beyond the walls",
      "Volume taken beyond the reference, within the leeway of its cut."},
     [](const Measured& m) { return Sum_m3(m.task.near) * kMm3; }},
    {kTask,
     {"outside_removed_mm3", "mm3", "Cut elsewhere",
      "Volume taken farther than the leeway from the reference's cut, neighbours apart."},
     [](const Measured& m) {
       return (Sum_m3(m.task.outside) - Of(m.task.outside, Tissue::kNeighbour)) * kMm3;
     }},
    {kTask,
     {"damage_percent", "%", "Damage",
      "Volume taken farther than the leeway from the reference's cut, of the task's volume."},
     [](const Measured& m) { return Percent(Sum_m3(m.task.outside), m.task.task_m3()); }},
    {kTask,
     {"neighbour_removed_mm3", "mm3", "Neighbour cut",
      "Volume of the neighbouring teeth that went."},
     [](const Measured& m) { return Removed(m, Tissue::kNeighbour); },
     WithNeighbour},
    {kCover,
     {"neighbour_depth_mm", "mm", "Depth in the neighbour",
      "Deepest place in a neighbouring tooth under its own surface."},
     [](const Measured& m) { return m.neighbour_depth_m * kMm; },
     WithNeighbour},
    {kTask,
     {"caries_left_mm3", "mm3", "Caries left",
      "Volume of caries that the reference took away and the attempt left."},
     [](const Measured& m) { return Of(m.task.missed, Tissue::kCaries) * kMm3; },
     WithCaries},
    {kTask,
     {"caries_left_percent", "%", "Caries left, share",
      "Share of the caries that the reference took away which the attempt left."},
     [](const Measured& m) {
       return Percent(Of(m.task.missed, Tissue::kCaries), Of(m.task.task, Tissue::kCaries));
     },
     WithCaries},
    {kTask,
     {"sound_removed_mm3", "mm3", "Sound tissue too much",
      "Enamel and dentin taken beyond what the reference took, near its cut and elsewhere."},
     [](const Measured& m) {
       double sum = 0;
       for (Tissue t : {Tissue::kEnamel, Tissue::kDentin}) {
         sum += Of(m.task.near, t) + Of(m.task.outside, t);
       }
       return sum * kMm3;
     }},
    {kTask,
     {"removed_enamel_mm3", "mm3", "Enamel removed", "Volume of enamel that went."},
     [](const Measured& m) { return Removed(m, Tissue::kEnamel); }},
    {kTask,
     {"removed_dentin_mm3", "mm3", "Dentin removed", "Volume of dentin that went."},
     [](const Measured& m) { return Removed(m, Tissue::kDentin); }},
    {kTask,
     {"removed_pulp_mm3", "mm3", "Pulp removed", "Volume of pulp that went."},
     [](const Measured& m) { return Removed(m, Tissue::kPulp); }},
    {kTask,
     {"pulp_exposed_mm2", "mm2", "Pulp exposed",
      "Area of the final surface that is pulp and was not surface before."},
     [](const Measured& m) { return m.pulp_exposed_m2 * kMm2; }},
    {kCover,
     {"remaining_dentin_mm", "mm", "Least cover of the pulp",
      "Least distance from the cut to the pulp, at most 3 mm; 0 where it lies open."},
     [](const Measured& m) { return m.remaining_dentin_m * kMm; },
     WithPulp},
    {kRecording,
     {"force_sent_p95_n", "N", "Force, 95th percentile",
      "Sent force that 95 % of the ticks with any force stay within.", "", "", AtLimit::kAtLeast},
     [](const Measured& m) { return m.process->force_sent_p95_n(); }},
    {kRecording,
     {"force_sent_max_n", "N", "Largest force", "Largest sent force of any tick.", "", "",
      AtLimit::kAtLeast},
     [](const Measured& m) { return m.process->force_sent_max_n(); }},
    {kRecording,
     {"force_sent_mean_cutting_n", "N", "Mean force while cutting",
      "Mean sent force over the ticks that removed something.", "", "", AtLimit::kAtLeast},
     [](const Measured& m) { return m.process->force_sent_mean_cutting_n(); }},
    {kRecording,
     {"path_length_mm", "mm", "Path length", "Length of the bur tip's path."},
     [](const Measured& m) { return m.process->anchor_path_m() * kMm; }},
    {kRecording,
     {"time_s", "s", "Time", "Duration of the attempt, gaps included."},
     [](const Measured& m) { return m.process->duration_s(); }},
    {kRecording,
     {"cutting_time_s", "s", "Cutting time", "Time less than 50 ms after something was removed."},
     [](const Measured& m) { return m.process->cutting_s(); }},
    {kPathInTime,
     {"dtw_pose_mm", "mm", "Path against the reference",
      "Mean distance of the bur from the reference's along the best alignment in time."},
     [](const Measured& m) { return m.align_pose_m * kMm; }},
    {kPathInTime,
     {"dtw_force_n", "N", "Force against the reference",
      "Mean difference of the sent force from the reference's along the best alignment in time.",
      "", "", AtLimit::kUnknown},
     [](const Measured& m) { return m.align_force_n; }},
    {kPathInTime,
     {"frechet_pose_mm", "mm", "Farthest from the reference's path",
      "Discrete Frechet distance of the bur's path from the reference's, in time."},
     [](const Measured& m) { return m.frechet_pose_m * kMm; }},
    {kPathByWay,
     {"dtw_way_mm", "mm", "Way against the reference's",
      "Mean distance of the bur from the reference's along the best alignment of their ways."},
     [](const Measured& m) { return m.align_way_m * kMm; }},
    {kPathByWay,
     {"frechet_way_mm", "mm", "Farthest from the reference's way",
      "Discrete Frechet distance of the bur's way from the reference's."},
     [](const Measured& m) { return m.frechet_way_m * kMm; }},
    {kRecording,
     {"idle_time_s", "s", "Time away from the tooth", "Time outside contacts, without gaps."},
     [](const Measured& m) { return m.process->idle_s(); }},
    {kRecording,
     {"contact_count", "count", "Contacts", "How often the bur came to the tooth."},
     [](const Measured& m) { return static_cast<double>(m.process->strokes().contacts()); }},
    {kRecording,
     {"stroke_count", "count", "Strokes", "Contacts that removed something."},
     [](const Measured& m) { return static_cast<double>(m.process->strokes().Strokes().size()); }},
    {kRecording,
     {"angulation_mean_deg", "deg", "Tilt of the bur",
      "Mean angle of the bur's axis against the tooth's while cutting."},
     [](const Measured& m) { return *m.process->angulation_mean_deg(); },
     WithCut},
    {kRecording,
     {"angulation_p95_deg", "deg", "Tilt of the bur, 95th percentile",
      "Angle of the bur's axis against the tooth's that 95 % of the cutting stays within."},
     [](const Measured& m) { return *m.process->angulation_p95_deg(); },
     WithCut},
    {kRecording,
     {"impulse_n_s", "N s", "Impulse", "Sent force, summed over time.", "", "", AtLimit::kAtLeast},
     [](const Measured& m) { return m.process->impulse_n_s(); }},
    {kRecording,
     {"work_mj", "mJ", "Work of the hand", "What the hand gave to the tool, less what it got back.",
      "", "", AtLimit::kUnknown},
     [](const Measured& m) { return m.process->work_j() * 1e3; }},
    {kRecording,
     {"force_rate_p95_n_per_s", "N/s", "Change of force, 95th percentile",
      "Rate of the sent force that 95 % of the steps of 10 ms with any force stay within.", "", "",
      AtLimit::kUnknown},
     [](const Measured& m) { return m.process->force_rate_p95_n_per_s(); }},
    {kRecording,
     {"enamel_rate_mm3_per_s", "mm3/s", "Enamel removed, rate", "Of cutting time."},
     RemovalRate<Tissue::kEnamel>,
     WithRemoved<Tissue::kEnamel>},
    {kRecording,
     {"dentin_rate_mm3_per_s", "mm3/s", "Dentin removed, rate", "Of cutting time."},
     RemovalRate<Tissue::kDentin>,
     WithRemoved<Tissue::kDentin>},
    {kRecording,
     {"caries_rate_mm3_per_s", "mm3/s", "Caries removed, rate", "Of cutting time."},
     RemovalRate<Tissue::kCaries>,
     WithRemoved<Tissue::kCaries>},
    {kRecording,
     {"enamel_half_s", "s", "Half of the enamel", "By when half of the removed enamel was gone."},
     Half_s<Tissue::kEnamel>,
     WithRemoved<Tissue::kEnamel>},
    {kRecording,
     {"dentin_half_s", "s", "Half of the dentin", "By when half of the removed dentin was gone."},
     Half_s<Tissue::kDentin>,
     WithRemoved<Tissue::kDentin>},
    {kRecording,
     {"caries_half_s", "s", "Half of the caries", "By when half of the removed caries was gone."},
     Half_s<Tissue::kCaries>,
     WithRemoved<Tissue::kCaries>},
    {kMotion,
     {"smoothness_ldlj", "ratio", "Smoothness, by jerk",
      "Log dimensionless jerk of the bur's speed, median of the strokes; higher is smoother."},
     [](const Measured& m) { return *m.smoothness.log_dimensionless_jerk; },
     [](const Measured& m) { return IfMade(m.smoothness.log_dimensionless_jerk); }},
    {kMotion,
     {"smoothness_sparc", "ratio", "Smoothness, by spectrum",
      "Spectral arc length of the bur's speed, median of the strokes; higher is smoother."},
     [](const Measured& m) { return *m.smoothness.spectral_arc_length; },
     [](const Measured& m) { return IfMade(m.smoothness.spectral_arc_length); }},
    {kMotion,
     {"tremor_um", "um", "Tremor",
      "Root mean square of the hand's position in contact, 8 to 12 Hz."},
     [](const Measured& m) { return *m.process->tremor_m() * 1e6; },
     [](const Measured& m) { return IfMade(m.process->tremor_m()); }},
    {kRecording,
     {"limiter_share_percent", "%", "Device at its limit",
      "Share of the ticks in which the device's peak force bounded the force."},
     [](const Measured& m) {
       return Percent(static_cast<double>(m.process->bounded_ticks()),
                      static_cast<double>(m.process->ticks()));
     }},
};

}  // namespace

std::span<const MetricInfo> Metrics() {
  static const std::vector<MetricInfo> infos = [] {
    std::vector<MetricInfo> out;
    for (const Entry& entry : kRegistry) out.push_back(entry.info);
    return out;
  }();
  return infos;
}

const MetricInfo* FindMetric(std::string_view name) {
  for (const MetricInfo& info : Metrics()) {
    if (info.name == name) return &info;
  }
  return nullptr;
}

MetricPlan MetricPlan::All() {
  MetricPlan plan;
  plan.groups_.set();
  return plan;
}

MetricPlan MetricPlan::For(const scene::Rubric& rubric) {
  MetricPlan plan;
  for (MetricGroup group : kBaseGroups) plan.Add(group);
  auto use = [&](const std::string& metric) {
    for (const Entry& entry : kRegistry) {
      if (entry.info.name == metric) plan.Add(entry.group);
    }
  };
  for (const scene::RubricCriterion& criterion : rubric.criteria) use(criterion.metric);
  for (const scene::RubricGate& gate : rubric.gates) use(gate.metric);
  return plan;
}

Disturbance DisturbanceOf(const ProcessRecorder& process) {
  auto percent = [](uint64_t part, uint64_t whole) {
    return Percent(static_cast<double>(part), static_cast<double>(whole));
  };
  return {percent(process.late_ticks(), process.ticks()),
          percent(process.gap_ticks(), process.ticks() + process.gap_ticks()),
          percent(process.bounded_ticks(), process.force_ticks())};
}

MetricSet Collect(const Measured& m, const MetricPlan& plan) {
  MetricSet out;
  const bool limited = DisturbanceOf(*m.process).limited_percent > kMostLimited_percent;
  for (const Entry& entry : kRegistry) {
    std::string name(entry.info.name);
    const bool of_path =
        entry.group == MetricGroup::kPathInTime || entry.group == MetricGroup::kPathByWay;
    const State state = !plan.Has(entry.group)             ? NoValue::kNotUsed
                        : of_path && !m.reference_recorded ? NoValue::kNotInTask
                                                           : entry.state(m);
    if (state) {
      out.missing.push_back({std::move(name), *state});
    } else {
      // Adding zero turns -0 into 0.
      out.values.push_back({std::move(name), entry.value(m) + 0.0, std::string(entry.info.unit),
                            limited && entry.info.at_limit != AtLimit::kSame});
    }
  }
  return out;
}

}  // namespace enamel::scoring
