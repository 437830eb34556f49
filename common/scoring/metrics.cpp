#include "common/scoring/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "common/scoring/deviation.h"
#include "common/scoring/path_align.h"
#include "common/scoring/shape.h"
#include "common/scoring/task.h"
#include "common/scoring/zones.h"

namespace enamel::scoring {
namespace {

using cutting::Tissue;
using cutting::Volume;

constexpr double kMm = 1e3, kMm2 = 1e6, kMm3 = 1e9;

constexpr double kDentinLimit_m = 3e-3;  // more than this over the pulp is safe by any measure

// Everything measured about one attempt; the registry below picks from it.
struct Measured {
  BoxVolume target, leeway, container;  // each box whole, the inner ones included
  TissueVolumes_m3 removed{};
  TaskVolumes task;
  DeviationFigures deviation;
  double deepest_over_m = 0;
  Walls walls{};
  OutlineFigures outline;
  bool has_pulp = false, has_neighbour = false;
  double neighbour_depth_m = 0;
  double remaining_dentin_m = 0;
  double pulp_exposed_m2 = 0;
  double align_pose_m = 0, align_force_n = 0;
  const ProcessRecorder* process = nullptr;
};

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
template <Part kPart>
State WithWall(const Measured& m) {
  return Unless(m.walls[kPart].in_task);
}
template <Part kPart>
State WithMadeWall(const Measured& m) {
  if (!m.walls[kPart].in_task) return NoValue::kNotInTask;
  return m.walls[kPart].made ? State{} : NoValue::kNotMade;
}
State WithUprightWalls(const Measured& m) {
  bool any = false;
  for (size_t p = 0; p < kFloor; ++p) {
    if (!m.walls[p].in_task) continue;
    if (!m.walls[p].made) return NoValue::kNotMade;
    any = true;
  }
  return Unless(any);
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

// A table and not a switch: what is measured, shown and named in a rubric is the same list.
struct Entry {
  MetricInfo info;
  double (*value)(const Measured&);
  State (*state)(const Measured&) = Always;
};

// Formulas in full, with sources: schemas/score.md.
constexpr Entry kRegistry[] = {
    {{"zone_target_removed_percent", "%", "Target removed",
      "Share of the solid inside the target box that went."},
     [](const Measured& m) { return Percent(m.target.removed_m3, m.target.solid_m3); }},
    {{"zone_leeway_removed_percent", "%", "Leeway removed",
      "Share of the solid between target and leeway box that went."},
     [](const Measured& m) {
       return Percent(m.leeway.removed_m3 - m.target.removed_m3,
                      m.leeway.solid_m3 - m.target.solid_m3);
     }},
    {{"zone_container_removed_mm3", "mm3", "Container removed",
      "Volume that went between leeway and container box, which must stay."},
     [](const Measured& m) {
       // Where nothing went, rounding of two sums must not say less than nothing.
       return std::max(0.0, m.container.removed_m3 - m.leeway.removed_m3) * kMm3;
     }},
    {{"deviation_rms_mm", "mm", "Deviation from the reference",
      "Root mean square distance of the attempt's surface from the reference's cut, by area."},
     [](const Measured& m) { return m.deviation.rms_m * kMm; }},
    {{"deviation_p95_mm", "mm", "Largest deviations",
      "Distance that 95 % of the reference's cut surface stays within of the attempt's."},
     [](const Measured& m) { return m.deviation.p95_m * kMm; }},
    {{"within_100um_percent", "%", "Within 0.1 mm of the reference",
      "Share of the reference's cut surface that is no farther than 0.1 mm from the attempt's."},
     [](const Measured& m) { return 100 * m.deviation.within[0]; }},
    {{"within_200um_percent", "%", "Within 0.2 mm of the reference", "The same for 0.2 mm."},
     [](const Measured& m) { return 100 * m.deviation.within[1]; }},
    {{"within_300um_percent", "%", "Within 0.3 mm of the reference", "The same for 0.3 mm."},
     [](const Measured& m) { return 100 * m.deviation.within[2]; }},
    {{"within_500um_percent", "%", "Within 0.5 mm of the reference", "The same for 0.5 mm."},
     [](const Measured& m) { return 100 * m.deviation.within[3]; }},
    {{"deepest_over_mm", "mm", "Deepest place beyond the reference",
      "At least 0.02 mm2 of the cut lies so deep under the reference's surface."},
     [](const Measured& m) { return m.deepest_over_m * kMm; }},
    {{"most_left_mm", "mm", "Most left standing",
      "At least 0.02 mm2 of the reference's cut lies so deep under the attempt's surface."},
     [](const Measured& m) { return m.deviation.most_left_m * kMm; }},
    {{"wall_mesial_mm", "mm", "Mesial wall", "Median signed deviation of the mesial wall, by area.",
      "too deep", "short"},
     [](const Measured& m) { return m.walls[kMesial].offset_m * kMm; },
     WithWall<kMesial>},
    {{"wall_distal_mm", "mm", "Distal wall", "Median signed deviation of the distal wall, by area.",
      "too deep", "short"},
     [](const Measured& m) { return m.walls[kDistal].offset_m * kMm; },
     WithWall<kDistal>},
    {{"wall_buccal_mm", "mm", "Buccal wall", "Median signed deviation of the buccal wall, by area.",
      "too deep", "short"},
     [](const Measured& m) { return m.walls[kBuccal].offset_m * kMm; },
     WithWall<kBuccal>},
    {{"wall_lingual_mm", "mm", "Lingual wall",
      "Median signed deviation of the lingual wall, by area.", "too deep", "short"},
     [](const Measured& m) { return m.walls[kLingual].offset_m * kMm; },
     WithWall<kLingual>},
    {{"floor_mm", "mm", "Floor", "Median signed deviation of the cavity's floor, by area.",
      "too deep", "too shallow"},
     [](const Measured& m) { return m.walls[kFloor].offset_m * kMm; },
     WithWall<kFloor>},
    {{"tilt_mesial_deg", "deg", "Mesial wall, tilt",
      "Angle of the mesial wall against the reference's, by a plane through it.",
      "more open at the top", "undercut"},
     [](const Measured& m) { return m.walls[kMesial].tilt_deg; },
     WithMadeWall<kMesial>},
    {{"tilt_distal_deg", "deg", "Distal wall, tilt",
      "Angle of the distal wall against the reference's, by a plane through it.",
      "more open at the top", "undercut"},
     [](const Measured& m) { return m.walls[kDistal].tilt_deg; },
     WithMadeWall<kDistal>},
    {{"tilt_buccal_deg", "deg", "Buccal wall, tilt",
      "Angle of the buccal wall against the reference's, by a plane through it.",
      "more open at the top", "undercut"},
     [](const Measured& m) { return m.walls[kBuccal].tilt_deg; },
     WithMadeWall<kBuccal>},
    {{"tilt_lingual_deg", "deg", "Lingual wall, tilt",
      "Angle of the lingual wall against the reference's, by a plane through it.",
      "more open at the top", "undercut"},
     [](const Measured& m) { return m.walls[kLingual].tilt_deg; },
     WithMadeWall<kLingual>},
    {{"tilt_floor_deg", "deg", "Floor, tilt",
      "Angle of the floor against the reference's, by a plane through it."},
     [](const Measured& m) { return m.walls[kFloor].tilt_deg; },
     WithMadeWall<kFloor>},
    {{"wall_tilt_deg", "deg", "Slope of the walls",
      "Largest angle of any wall against the reference's, whichever way."},
     [](const Measured& m) {
       return WorstWall(m, [](const WallFigures& w) { return std::fabs(w.tilt_deg); });
     },
     WithUprightWalls},
    {{"undercut_deg", "deg", "Undercut",
      "Largest angle by which a wall leans over the cavity, against the vertical."},
     [](const Measured& m) {
       return WorstWall(m, [](const WallFigures& w) { return -w.opens_deg; });
     },
     WithUprightWalls},
    {{"wall_waviness_mm", "mm", "Waviness of the walls",
      "Largest root mean square height of a wall about its own plane, against the reference's."},
     [](const Measured& m) {
       return WorstWall(m, [](const WallFigures& w) { return w.waviness_m; }) * kMm;
     },
     WithUprightWalls},
    {{"floor_waviness_mm", "mm", "Waviness of the floor",
      "Root mean square height of the floor about its own plane, against the reference's."},
     [](const Measured& m) { return m.walls[kFloor].waviness_m * kMm; },
     WithMadeWall<kFloor>},
    {{"outline_over_mm", "mm", "Outline too wide",
      "How far 95 % of the outline on the tooth stays within beyond the reference's."},
     [](const Measured& m) { return m.outline.over_m * kMm; },
     WithOutline},
    {{"outline_short_mm", "mm", "Outline short",
      "How far 95 % of the outline on the tooth stays within short of the reference's."},
     [](const Measured& m) { return m.outline.short_m * kMm; },
     WithOutline},
    {{"task_done_percent", "%", "Task done",
      "Share of what the reference took away that the attempt took away too."},
     [](const Measured& m) { return Percent(m.task.done_m3(), m.task.task_m3()); }},
    {{"overlap_percent", "%", "Overlap with the reference",
      "Dice coefficient of the volumes that attempt and reference took away."},
     [](const Measured& m) {
       return Percent(2 * m.task.done_m3(), m.task.task_m3() + Sum_m3(m.removed));
     }},
    {{"missed_mm3", "mm3", "Left of the task",
      "Volume that the reference took away and the attempt left."},
     [](const Measured& m) { return Sum_m3(m.task.missed) * kMm3; }},
    {{"overcut_mm3", "mm3", "Beyond the walls",
      "Volume taken beyond the reference, within the leeway of its cut."},
     [](const Measured& m) { return Sum_m3(m.task.near) * kMm3; }},
    {{"outside_removed_mm3", "mm3", "Cut elsewhere",
      "Volume taken farther than the leeway from the reference's cut, neighbours apart."},
     [](const Measured& m) {
       return (Sum_m3(m.task.outside) - Of(m.task.outside, Tissue::kNeighbour)) * kMm3;
     }},
    {{"damage_percent", "%", "Damage",
      "Volume taken farther than the leeway from the reference's cut, of the task's volume."},
     [](const Measured& m) { return Percent(Sum_m3(m.task.outside), m.task.task_m3()); }},
    {{"neighbour_removed_mm3", "mm3", "Neighbour cut",
      "Volume of the neighbouring teeth that went."},
     [](const Measured& m) { return Removed(m, Tissue::kNeighbour); },
     WithNeighbour},
    {{"neighbour_depth_mm", "mm", "Depth in the neighbour",
      "Deepest place in a neighbouring tooth under its own surface."},
     [](const Measured& m) { return m.neighbour_depth_m * kMm; },
     WithNeighbour},
    {{"caries_left_mm3", "mm3", "Caries left",
      "Volume of caries that the reference took away and the attempt left."},
     [](const Measured& m) { return Of(m.task.missed, Tissue::kCaries) * kMm3; },
     WithCaries},
    {{"caries_left_percent", "%", "Caries left, share",
      "Share of the caries that the reference took away which the attempt left."},
     [](const Measured& m) {
       return Percent(Of(m.task.missed, Tissue::kCaries), Of(m.task.task, Tissue::kCaries));
     },
     WithCaries},
    {{"sound_removed_mm3", "mm3", "Sound tissue too much",
      "Enamel and dentin taken beyond what the reference took, near its cut and elsewhere."},
     [](const Measured& m) {
       double sum = 0;
       for (Tissue t : {Tissue::kEnamel, Tissue::kDentin}) {
         sum += Of(m.task.near, t) + Of(m.task.outside, t);
       }
       return sum * kMm3;
     }},
    {{"removed_enamel_mm3", "mm3", "Enamel removed", "Volume of enamel that went."},
     [](const Measured& m) { return Removed(m, Tissue::kEnamel); }},
    {{"removed_dentin_mm3", "mm3", "Dentin removed", "Volume of dentin that went."},
     [](const Measured& m) { return Removed(m, Tissue::kDentin); }},
    {{"removed_pulp_mm3", "mm3", "Pulp removed", "Volume of pulp that went."},
     [](const Measured& m) { return Removed(m, Tissue::kPulp); }},
    {{"pulp_exposed_mm2", "mm2", "Pulp exposed",
      "Area of the final surface that is pulp and was not surface before."},
     [](const Measured& m) { return m.pulp_exposed_m2 * kMm2; }},
    {{"remaining_dentin_mm", "mm", "Least cover of the pulp",
      "Least distance from the cut to the pulp, at most 3 mm; 0 where it lies open."},
     [](const Measured& m) { return m.remaining_dentin_m * kMm; },
     WithPulp},
    {{"force_sent_p95_n", "N", "Force, 95th percentile",
      "Sent force that 95 % of the ticks with any force stay within."},
     [](const Measured& m) { return m.process->force_sent_p95_n(); }},
    {{"force_sent_max_n", "N", "Largest force", "Largest sent force of any tick."},
     [](const Measured& m) { return m.process->force_sent_max_n(); }},
    {{"force_sent_mean_cutting_n", "N", "Mean force while cutting",
      "Mean sent force over the ticks that removed something."},
     [](const Measured& m) { return m.process->force_sent_mean_cutting_n(); }},
    {{"path_length_mm", "mm", "Path length", "Length of the bur tip's path."},
     [](const Measured& m) { return m.process->anchor_path_m() * kMm; }},
    {{"time_s", "s", "Time", "Duration of the attempt, gaps included."},
     [](const Measured& m) { return m.process->duration_s(); }},
    {{"cutting_time_s", "s", "Cutting time", "Time less than 50 ms after something was removed."},
     [](const Measured& m) { return m.process->cutting_s(); }},
    {{"dtw_pose_mm", "mm", "Path against the reference",
      "Mean distance of the bur from the reference's along the best alignment in time."},
     [](const Measured& m) { return m.align_pose_m * kMm; }},
    {{"dtw_force_n", "N", "Force against the reference",
      "Mean difference of the sent force from the reference's along the best alignment in time."},
     [](const Measured& m) { return m.align_force_n; }},
    {{"limiter_share_percent", "%", "Device at its limit",
      "Share of the ticks in which the device's peak force bounded the force."},
     [](const Measured& m) {
       return Percent(static_cast<double>(m.process->bounded_ticks()),
                      static_cast<double>(m.process->ticks()));
     }},
};

Status CheckInputs(const AttemptData& attempt, const AttemptData& reference) {
  for (const AttemptData* data : {&attempt, &reference}) {
    // A missing part is a mistake of the caller's; a grid or a recording that does not fit comes
    // from outside.
    ENAMEL_CHECK(data->initial && data->final_volume && data->final_surface && data->process);
    if (!(data->initial->spec() == attempt.initial->spec()) ||
        !(data->final_volume->spec() == attempt.initial->spec())) {
      return Status(Code::kInvalidInput,
                    "attempt and reference have different grids (voxel size, origin or extent): "
                    "compare cuts of the same scene only");
    }
    if (data->process->ticks() == 0) {
      return Status(Code::kInvalidInput, std::string("the recording of the ") +
                                             (data == &attempt ? "attempt" : "reference") +
                                             " is empty: nothing to measure");
    }
  }
  return Status::Ok();
}

// One side of the comparison with what is worked out of it once.
struct Side {
  explicit Side(const AttemptData& data)
      : cut(CutVertices(*data.final_surface, *data.initial, *data.final_volume)),
        areas_m2(VertexAreas_m2(*data.final_surface)),
        cut_side{data.final_volume, data.final_surface, &cut, &areas_m2} {}
  Side(const Side&) = delete;

  const std::vector<bool> cut;
  const std::vector<double> areas_m2;
  const CutSide cut_side;
};

double PulpExposed_m2(const AttemptData& attempt, const std::vector<double>& areas_m2) {
  const surface::Mesh& mesh = *attempt.final_surface;
  double h = attempt.initial->spec().voxel_m(), sum = 0;
  for (size_t i = 0; i < mesh.position_m.size(); ++i) {
    if (mesh.tissue[i] != static_cast<uint8_t>(Tissue::kPulp)) continue;
    // Deeper than a voxel's half under the initial surface: it was not surface before.
    if (attempt.initial->DistanceAt_m(dvec3(mesh.position_m[i])) < -0.5 * h) sum += areas_m2[i];
  }
  return sum;
}

// Deepest vertex of the final surface in a neighbour, under the surface it had.
double NeighbourDepth_m(const AttemptData& attempt, const Side& side) {
  const surface::Mesh& mesh = *attempt.final_surface;
  double deepest = 0;
  std::optional<surface::DistanceQuery> before;
  for (size_t i = 0; i < mesh.position_m.size(); ++i) {
    if (!side.cut[i] || mesh.tissue[i] != static_cast<uint8_t>(Tissue::kNeighbour)) continue;
    // Only where a neighbour was cut at all; phi itself saturates at four voxels.
    if (!before) before.emplace(surface::ExtractSurface(*attempt.initial));
    deepest = std::max(deepest, before->Distance_m(dvec3(mesh.position_m[i]), kDeviationLimit_m));
  }
  return deepest;
}

bool Has(const Volume& volume, Tissue tissue) {
  for (int b = 0; b < volume.spec().brick_count(); ++b) {
    // A brick without labels is of one tissue throughout.
    if (!volume.HasLabels(b)) {
      if (volume.UniformTissue(b) == tissue) return true;
      continue;
    }
    const auto& labels = volume.Labels(b).tissue;
    if (std::find(labels.begin(), labels.end(), static_cast<uint8_t>(tissue)) != labels.end()) {
      return true;
    }
  }
  return false;
}

// What depends on the tissues that the tooth has.
void MeasureTissues(const AttemptData& attempt, const Side& side, Measured& m) {
  m.has_pulp = Has(*attempt.initial, Tissue::kPulp);
  m.has_neighbour = Has(*attempt.initial, Tissue::kNeighbour);
  if (m.has_pulp) {
    m.pulp_exposed_m2 = PulpExposed_m2(attempt, side.areas_m2);
    m.remaining_dentin_m = RemainingDentin_m(*attempt.initial, side.cut_side, kDentinLimit_m);
  }
  if (m.has_neighbour) m.neighbour_depth_m = NeighbourDepth_m(attempt, side);
}

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

Result<MetricSet> ComputeMetrics(const scene::Scene& scene, const scene::Exercise& exercise,
                                 const AttemptData& attempt, const AttemptData& reference,
                                 const std::function<void(double)>& progress) {
  auto tell = [&](double done) {
    if (progress) progress(done);
  };
  ENAMEL_RETURN_IF_ERROR(CheckInputs(attempt, reference));
  ENAMEL_ASSIGN_OR_RETURN(const ZoneBoxes boxes, BoxesOf(scene, exercise.target));
  const Volume& initial = *attempt.initial;

  Measured m;
  m.process = attempt.process;
  m.target = MeasureBox(initial, *attempt.final_volume, boxes.target);
  if (m.target.solid_m3 <= 0) {
    return Status(Code::kInvalidInput,
                  "the exercise's target holds no solid in scene \"" + scene.name +
                      "\": move its landmark or make it deeper",
                  "target");
  }
  m.leeway = MeasureBox(initial, *attempt.final_volume, boxes.leeway);
  m.container = MeasureBox(initial, *attempt.final_volume, boxes.container);
  m.removed = RemovedPerTissue_m3(initial, *attempt.final_volume);
  tell(0.15);

  // Once for each side: cut vertices and areas are asked for by half a dozen metrics.
  const Side a(attempt), r(reference);
  m.task = MeasureTask(initial, *attempt.final_volume, *reference.final_volume,
                       CutPart(*reference.final_surface, r.cut),
                       NearOf_m(exercise.target, initial.spec()));
  tell(0.3);
  std::vector<float> own;
  if (!attempt.deviation_m) {
    own = DeviationPerVertex(*attempt.final_surface, initial, *attempt.final_volume,
                             *reference.final_volume, *reference.final_surface);
  }
  // The server has it for the heat map already.
  const std::vector<float>& deviation = attempt.deviation_m ? *attempt.deviation_m : own;
  m.deepest_over_m = DeepestOver_m(a.cut_side, deviation);
  tell(0.5);
  const std::vector<float> back =
      DeviationPerVertex(*reference.final_surface, initial, *reference.final_volume,
                         *attempt.final_volume, *attempt.final_surface);
  m.deviation = MeasureDeviation(r.cut_side, back);
  m.walls =
      MeasureWalls(a.cut_side, r.cut_side, back, boxes.target, exercise.target.depth_um * 1e-6);
  m.outline = MeasureOutline(initial, a.cut_side, r.cut_side);
  tell(0.7);
  MeasureTissues(attempt, a, m);
  tell(0.8);
  const PathPair paths = ResampleAlike(*attempt.process, *reference.process, PathBy::kTime);
  m.align_pose_m = AlignPoses(paths).mean_cost;
  m.align_force_n = AlignForces(paths).mean_cost;
  tell(1);

  MetricSet out;
  for (const Entry& entry : kRegistry) {
    std::string name(entry.info.name);
    if (State state = entry.state(m)) {
      out.missing.push_back({std::move(name), *state});
    } else {
      // Adding zero turns -0 into 0.
      out.values.push_back({std::move(name), entry.value(m) + 0.0, std::string(entry.info.unit)});
    }
  }
  return out;
}

}  // namespace enamel::scoring
