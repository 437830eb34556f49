#include "common/scoring/metrics.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "common/scene/preparation.h"
#include "common/scene/tooth_number.h"
#include "common/scoring/deviation.h"
#include "common/scoring/measured.h"
#include "common/scoring/movement/path_align.h"
#include "common/scoring/uncertainty.h"

namespace enamel::scoring {
namespace {

using cutting::Tissue;
using cutting::Volume;

constexpr double kDentinLimit_m = 3e-3;  // more than this over the pulp is safe by any measure

Status CheckInputs(const AttemptData& attempt, const AttemptData& reference) {
  for (const AttemptData* data : {&attempt, &reference}) {
    // A missing part is a mistake of the caller's; a grid or a recording that does not fit comes
    // from outside.
    ENAMEL_CHECK(data->initial && data->final_volume && data->final_surface);
    ENAMEL_CHECK(data->process || data == &reference);
    if (!(data->initial->spec() == attempt.initial->spec()) ||
        !(data->final_volume->spec() == attempt.initial->spec())) {
      return Status(Code::kInvalidInput,
                    "attempt and reference have different grids (voxel size, origin or extent): "
                    "compare cuts of the same scene only");
    }
    if (data->process && data->process->ticks() == 0) {
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

// The metrics of the tooth's tissues; `cover`: also the distance to pulp and the depth in a
// neighbour, which take longer.
void MeasureTissues(const AttemptData& attempt, const Side& side, bool cover, Measured& m) {
  m.has_pulp = Has(*attempt.initial, Tissue::kPulp);
  m.has_neighbour = Has(*attempt.initial, Tissue::kNeighbour);
  if (m.has_pulp) m.pulp_exposed_m2 = PulpExposed_m2(attempt, side.areas_m2);
  if (m.has_pulp && cover) {
    m.remaining_dentin = MeasureRemainingDentin(*attempt.initial, side.cut_side, kDentinLimit_m);
  }
  if (m.has_neighbour && cover) m.neighbour_depth_m = NeighbourDepth_m(attempt, side);
}

}  // namespace

Result<MetricSet> ComputeMetrics(const scene::Scene& scene, const scene::Exercise& exercise,
                                 const AttemptData& attempt, const AttemptData& reference,
                                 const std::function<bool(double)>& progress,
                                 const MetricPlan& plan) {
  auto tell = [&](double done) {
    return !progress || progress(done) ? Status::Ok()
                                       : Status(Code::kUnavailable, "the measuring was ended");
  };
  ENAMEL_RETURN_IF_ERROR(CheckInputs(attempt, reference));
  ENAMEL_ASSIGN_OR_RETURN(ZoneBoxes boxes, BoxesOf(scene, exercise.target));
  const Volume& initial = *attempt.initial;

  Measured m;
  m.process = attempt.process;
  m.voxel_m = initial.spec().voxel_m();
  const bool laid_on = reference.process == nullptr && exercise.target.prepared_tooth != nullptr;
  m.surface_u_m = SurfaceUncertainty_m(m.voxel_m, laid_on ? kRegistration_m : 0);
  m.reference_recorded = reference.process != nullptr;
  m.target = MeasureZone(initial, *attempt.final_volume, boxes, Zone::kTarget);
  if (m.target.solid_m3 <= 0) {
    return Status(Code::kInvalidInput,
                  "the exercise's target holds no solid in scene \"" + scene.name +
                      "\": move its landmark or make it deeper",
                  "target");
  }
  if (plan.Has(MetricGroup::kZones)) {
    GrowZones(initial, boxes);
    m.leeway = MeasureZone(initial, *attempt.final_volume, boxes, Zone::kLeeway);
    m.container = MeasureZone(initial, *attempt.final_volume, boxes, Zone::kContainer);
  }
  m.removed = RemovedPerTissue_m3(initial, *attempt.final_volume);
  ENAMEL_RETURN_IF_ERROR(tell(0.15));

  // Once for each side: half a dozen metrics need cut vertices and areas.
  const Side a(attempt), r(reference);
  for (size_t i = 0; i < a.cut.size(); ++i) {
    if (!a.cut[i]) continue;
    m.cut_area_m2 += a.areas_m2[i];
    if (attempt.final_surface->tissue[i] == static_cast<uint8_t>(Tissue::kCaries))
      m.caries_area_m2 += a.areas_m2[i];
  }
  const surface::DistanceQuery reference_cut(CutPart(*reference.final_surface, r.cut));
  m.task = MeasureTask(initial, *attempt.final_volume, *reference.final_volume, reference_cut,
                       NearOf_m(exercise.target, initial.spec()));
  m.sides_done = SidesDone(initial, *attempt.final_volume, *reference.final_volume, boxes.target);
  ENAMEL_RETURN_IF_ERROR(tell(0.3));
  std::vector<float> own;
  if (!attempt.deviation_m) {
    own = DeviationPerVertex(*attempt.final_surface, initial, *attempt.final_volume,
                             *reference.final_volume, *reference.final_surface);
  }
  // The server has it for the heat map already.
  const std::vector<float>& deviation = attempt.deviation_m ? *attempt.deviation_m : own;
  m.deepest_over = DeepestOver(a.cut_side, deviation);
  ENAMEL_RETURN_IF_ERROR(tell(0.5));
  const std::vector<float> back =
      DeviationPerVertex(*reference.final_surface, initial, *reference.final_volume,
                         *attempt.final_volume, *attempt.final_surface);
  m.deviation = MeasureDeviation(r.cut_side, back);
  if (plan.Has(MetricGroup::kWalls) || plan.Has(MetricGroup::kLineAngles)) {
    m.walls = MeasureWalls(initial, a.cut_side, r.cut_side, back, boxes.target,
                           exercise.target.depth_um * 1e-6);
  }
  if (plan.Has(MetricGroup::kLineAngles)) {
    m.line_angles = MeasureLineAngles(a.cut_side, m.walls, boxes.target);
  }
  if (plan.Has(MetricGroup::kMargin)) m.margin = MeasureMargin(initial, a.cut_side, r.cut_side);
  if (plan.Has(MetricGroup::kCrown) && IsCrown(exercise.target)) {
    ENAMEL_ASSIGN_OR_RETURN(const scene::PointUm at, scene::TargetPoint(scene, exercise.target));
    const dvec3 landmark_m = dvec3(at[0], at[1], at[2]) * 1e-6;
    m.crown =
        MeasureCrown(initial, a.cut_side, r.cut_side, landmark_m,
                     landmark_m.z - exercise.target.depth_um * 1e-6, scene::MesialX(scene.tooth));
    if (m.crown.in_task) {
      m.stump = MeasureStump(initial, *attempt.final_volume, *reference.final_volume, boxes.target,
                             landmark_m.z - exercise.target.depth_um * 1e-6);
    }
  }
  if (plan.Has(MetricGroup::kOutline)) m.outline = MeasureOutline(initial, a.cut_side, r.cut_side);
  ENAMEL_RETURN_IF_ERROR(tell(0.7));
  MeasureTissues(attempt, a, plan.Has(MetricGroup::kCover), m);
  // A stump's axial walls say it themselves. MetricPlan::For measures a crown wherever a table has a price.
  if (m.has_neighbour && plan.Has(MetricGroup::kCover) && !m.crown.in_task) {
    const Contact contact(initial, *reference.final_volume, scene.tooth, scene.up);
    if (!contact.thirds().empty()) m.contact = contact.Of(*attempt.final_volume);
  }
  ENAMEL_RETURN_IF_ERROR(tell(0.8));
  if (plan.Has(MetricGroup::kPathInTime) && reference.process) {
    const PathPair paths = ResampleAlike(*attempt.process, *reference.process, PathBy::kTime);
    m.align_pose_m = AlignPoses(paths).mean_cost;
    m.align_force_n = AlignForces(paths).mean_cost;
    m.frechet_pose_m = AlignPoses(paths, Pairing::kWorst).worst_cost;
  }
  if (plan.Has(MetricGroup::kPathByWay) && reference.process) {
    const PathPair paths = ResampleAlike(*attempt.process, *reference.process, PathBy::kArcLength);
    m.align_way_m = AlignPoses(paths).mean_cost;
    m.frechet_way_m = AlignPoses(paths, Pairing::kWorst).worst_cost;
  }
  if (plan.Has(MetricGroup::kMotion)) m.smoothness = attempt.process->MeasureSmoothness();
  ENAMEL_RETURN_IF_ERROR(tell(1));

  return Collect(m, plan);
}

}  // namespace enamel::scoring
