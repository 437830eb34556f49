#include "station/lab/sheet/examples.h"

#include <algorithm>
#include <cmath>

namespace enamel::station::lab {
namespace {

using Made = std::vector<Fault>;

// Of a box: how far a point is outside its four walls.
double OutsideWalls_m(const BoxCavity& b, const dvec3& p) {
  return std::max(std::fabs(p.x - b.centre_m.x) - b.half_x_m,
                  std::fabs(p.y - b.centre_m.y) - b.half_y_m);
}
Hollow Wanted(const Task& task) {
  return [task](const dvec3& p) { return task.Distance_m(p); };
}

// A lid of enamel stays over the cavity, all along its outline.
CutPair OutlineTooSmall(const GradedExercise& graded) {
  const Task& task = graded.task();
  constexpr double kLid_m = 0.4e-3;
  return {nullptr, Wanted(task), [task](const dvec3& p) {
            const BoxCavity& b = task.box;
            const double lid =
                std::max(-OutsideWalls_m(b, p) - kLid_m, b.centre_m.z - kLid_m - p.z);
            return std::max(task.Distance_m(p), -lid);
          }};
}

// The rim opens at 45 degrees from the height of the fossa on.
CutPair MarginBevelled(const GradedExercise& graded) {
  const Task& task = graded.task();
  return {nullptr, Wanted(task), [task](const dvec3& p) {
            const BoxCavity& b = task.box;
            const double up = p.z - b.centre_m.z;
            return std::min(task.Distance_m(p),
                            std::max(-up, (OutsideWalls_m(b, p) - up) / std::sqrt(2.0)));
          }};
}

// The box with its line angles between walls and floor rounded.
Hollow RoundedBox(const BoxCavity& b) {
  constexpr double kRadius_m = 0.8e-3;
  return [b](const dvec3& p) {
    const double out = OutsideWalls_m(b, p), down = b.centre_m.z - b.depth_m - p.z;
    const double x = out + kRadius_m, y = down + kRadius_m;
    return x > 0 && y > 0 ? std::sqrt(x * x + y * y) - kRadius_m : std::max(out, down);
  };
}
CutPair LineAnglesDull(const GradedExercise& graded) {
  const Task& task = graded.task();
  return {nullptr, Wanted(task), RoundedBox(task.box)};
}
CutPair LineAnglesSharp(const GradedExercise& graded) {
  const Task& task = graded.task();
  return {nullptr, RoundedBox(task.box), Wanted(task)};
}

// The stump with its buccal edge cut off at 45 degrees, this far along both sides of the edge that a
// flat top would have. The relief's edge lies lower: the bevel is narrower.
Hollow Bevelled(const CrownCut& crown, double off_m) {
  return [crown, off_m](const dvec3& p) {
    const CrownCut::Section& top = crown.at_top;
    const double beyond = p.y - top.middle_y_m - top.half_y_m + p.z - crown.top_z_m;
    return std::min(crown.Distance_m(p), -(beyond + off_m) / std::sqrt(2.0));
  };
}
constexpr double kBevel_m = 1.4e-3, kWideBevel_m = 2.4e-3;
CutPair BevelWide(const GradedExercise& graded) {
  const Task& task = graded.task();
  return {nullptr, Bevelled(task.crown, kBevel_m), Bevelled(task.crown, kWideBevel_m)};
}
CutPair BevelMissing(const GradedExercise& graded) {
  const Task& task = graded.task();
  return {nullptr, Bevelled(task.crown, kBevel_m), Wanted(task)};
}

// The floor this far over the highest pulp beneath it.
CutPair FloorOverPulp(const GradedExercise& graded, double cover_m) {
  constexpr size_t kFloor = 4;
  const cutting::Volume& tooth = graded.built().volume;
  BoxCavity box = graded.task().box;
  const double h = tooth.spec().voxel_m(), floor = box.centre_m.z - box.depth_m;
  double cover = 0;  // none found yet
  for (double x = -box.half_x_m; x <= box.half_x_m; x += h) {
    for (double y = -box.half_y_m; y <= box.half_y_m; y += h) {
      const double bottom = tooth.spec().origin_m().z;
      for (double z = floor; z > bottom && (cover == 0 || floor - z < cover); z -= h) {
        const dvec3 p(box.centre_m.x + x, box.centre_m.y + y, z);
        if (tooth.TissueAtPoint(p) == cutting::Tissue::kPulp) cover = floor - z;
      }
    }
  }
  box.faces[kFloor].moved_m = std::max(0.0, cover - cover_m);
  return {nullptr, Wanted(graded.task()), [box](const dvec3& p) { return box.Distance_m(p); }};
}

CutPair NearPulp(const GradedExercise& graded) { return FloorOverPulp(graded, 0.6e-3); }
CutPair IntoPulp(const GradedExercise& graded) { return FloorOverPulp(graded, -0.9e-3); }

const Fault* Largest(const Made& made, std::string_view name, double sign) {
  const Fault* out = nullptr;
  for (const Fault& f : made) {
    if (f.name != name || f.size * sign <= 0) continue;
    if (out == nullptr || std::fabs(f.size) > std::fabs(out->size)) out = &f;
  }
  return out;
}

}  // namespace

std::span<const Example> Examples() {
  constexpr auto kAcross = Plane::kMesiodistal, kAlong = Plane::kBuccolingual;
  using Map = std::vector<scene::RubricPoint>;
  // Bands of a school that judges what no built-in rubric does. They only decide what is called full
  // marks in the sentence.
  static const Map width = {{0.3, 0}, {0.6, 1}, {1, 1}, {1.4, 0}},
                   bevel = {{0.2, 0}, {0.8, 1}, {1.2, 1}, {1.8, 0}},
                   angle = {{60, 0}, {80, 1}, {100, 1}, {120, 0}},
                   radius = {{0, 0}, {0.2, 1}, {0.4, 1}, {0.6, 0}};
  static const std::vector<Example> examples = {
      {"over_extended", "wall_distal_mm", "molar", "class-1", "wall_distal"},
      {"under_extended", "wall_distal_mm", "molar", "class-1", "wall_distal", -1},
      {"too_deep", "floor_mm", "molar", "class-1", "floor"},
      {"too_shallow", "floor_mm", "molar", "class-1", "floor", -1},
      {"over_tapered", "convergence_mesiodistal_deg", "molar", "crown", "convergence"},
      {"undercut", "undercut_deg", "molar", "class-1", "undercut"},
      {"floor_slopes", "tilt_floor_deg", "molar", "class-1", "tilt_floor"},
      {"walls_inclined", "wall_tilt_deg", "molar", "class-1", "taper"},
      {"wall_wavy", "wall_waviness_mm", "molar", "class-1", "waviness", 1, nullptr, Plane::kLevel},
      {"floor_uneven", "floor_waviness_mm", "molar", "class-1", "floor_waviness"},
      {"outline_wide", "outline_over_mm", "molar", "class-1", "margin"},
      {"outline_short",
       "outline_short_mm",
       "molar",
       "class-1",
       "",
       1,
       OutlineTooSmall,
       kAcross,
       {{0.1, 1}, {0.4, 0}}},
      {"margin_angle", "cavosurface_deg", "molar", "class-1", "", 1, MarginBevelled, kAcross,
       angle},
      {"line_angle_dull", "line_angle_radius_mm", "molar", "class-1", "", 1, LineAnglesDull,
       kAcross, radius},
      {"line_angle_sharp", "line_angle_radius_mm", "molar", "class-1", "", 1, LineAnglesSharp,
       kAcross, radius},
      {"preparation_leans", "crown_axis_deg", "molar", "crown", "lean"},
      {"over_reduced", "reduction_top_percent", "molar", "crown", "top_over"},
      {"under_reduced", "reduction_top_percent", "molar", "crown", "top_short"},
      {"finish_line_wide", "finish_width_mm", "molar", "crown", "walls_over", 1, nullptr, kAcross,
       width},
      {"finish_line_narrow", "finish_width_mm", "molar", "crown", "walls_short", 1, nullptr,
       kAcross, width},
      {"finish_line_deep", "finish_depth_mm", "molar", "crown", "finish_line"},
      {"finish_line_high", "finish_depth_mm", "molar", "crown", "finish_line", -1},
      {"finish_line_uneven", "finish_waviness_mm", "molar", "crown", "finish_waviness"},
      {"finish_line_missing",
       "finish_complete_percent",
       "molar",
       "crown",
       "critical: finish_line_missing",
       1,
       nullptr,
       kAcross,
       {{80, 0}, {100, 1}}},
      {"bevel_wide", "bevel_buccal_mm", "molar", "crown", "", 1, BevelWide, kAlong, bevel},
      {"bevel_narrow", "bevel_buccal_mm", "molar", "crown", "", 1, BevelMissing, kAlong, bevel},
      {"neighbour_cut", "neighbour_removed_mm3", "molar-class-2", "class-2", "neighbour cut"},
      {"off_target", "deviation_rms_mm", "block", "cross", "walls_over"},
      {"gouge", "deepest_over_mm", "molar", "class-1", "gouge"},
      {"left_standing", "left_standing_mm3", "molar", "class-1", "pillar"},
      {"unfinished", "task_done_percent", "molar", "class-1", "stopped early"},
      {"caries_left", "caries_left_percent", "molar-caries", "caries", "caries left"},
      {"cut_elsewhere", "outside_removed_mm3", "molar", "class-1", "second hole", 1, nullptr,
       kAlong},
      {"sound_tissue_cut", "sound_removed_mm3", "molar-caries", "caries", "wall_distal"},
      {"pulp_exposed", "pulp_exposed_mm2", "molar", "class-1", "", 1, IntoPulp},
      {"cover_thin", "remaining_dentin_mm", "molar", "class-1", "", 1, NearPulp},
  };
  return examples;
}

Result<MadeExample> Make(const Example& example, const GradedExercise& graded, const Made& made) {
  MadeExample out;
  if (example.own != nullptr) {
    out.cut = example.own(graded);
  } else if (const Fault* fault = Largest(made, example.made, example.sign)) {
    out.cut = {nullptr, Wanted(graded.task()), fault->taken, fault->neighbours};
  } else {
    return Status(Code::kInternal, "no fault '" + std::string(example.made) + "' is made in " +
                                       graded.exercise().name + ", for the example of " +
                                       std::string(example.fault));
  }
  out.cut.tooth = &graded.built().volume;
  ENAMEL_ASSIGN_OR_RETURN(out.score, graded.Score(out.cut.taken, out.cut.neighbours));
  return out;
}

}  // namespace enamel::station::lab
