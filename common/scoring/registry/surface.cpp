#include <algorithm>
#include <cmath>

#include "common/scoring/registry/registry.h"

namespace enamel::scoring {
namespace {

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
// A wall that was cut away has no shape. One that the work has not come to is missed as that, and
// the others are judged.
State WithUprightWalls(const Measured& m) {
  bool in_task = false, made = false;
  for (size_t p = 0; p < kFloor; ++p) {
    const WallFigures& w = m.walls[p];
    if (!w.in_task) continue;
    if (!w.made && w.begun && w.offset_m > 0) return NoValue::kNotMade;
    in_task = true, made = made || w.made;
  }
  return in_task && !made ? State{NoValue::kNotMade} : Unless(in_task);
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

constexpr Entry kEntries[] = {
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
     {"divergence_mesial_deg", "deg", "Mesial wall, divergence",
      "Angle of the mesial wall against the way out of the cavity.", "more open at the top",
      "undercut"},
     [](const Measured& m) { return m.walls[kMesial].opens_deg; },
     WithMadeWall<kMesial>},
    {kWalls,
     {"divergence_distal_deg", "deg", "Distal wall, divergence",
      "Angle of the distal wall against the way out of the cavity.", "more open at the top",
      "undercut"},
     [](const Measured& m) { return m.walls[kDistal].opens_deg; },
     WithMadeWall<kDistal>},
    {kWalls,
     {"divergence_buccal_deg", "deg", "Buccal wall, divergence",
      "Angle of the buccal wall against the way out of the cavity.", "more open at the top",
      "undercut"},
     [](const Measured& m) { return m.walls[kBuccal].opens_deg; },
     WithMadeWall<kBuccal>},
    {kWalls,
     {"divergence_lingual_deg", "deg", "Lingual wall, divergence",
      "Angle of the lingual wall against the way out of the cavity.", "more open at the top",
      "undercut"},
     [](const Measured& m) { return m.walls[kLingual].opens_deg; },
     WithMadeWall<kLingual>},
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
};

}  // namespace

std::span<const Entry> SurfaceMetrics() { return kEntries; }

}  // namespace enamel::scoring
