#include "common/scoring/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "common/scoring/align.h"
#include "common/scoring/deviation.h"
#include "common/scoring/zones.h"

namespace enamel::scoring {
namespace {

using cutting::Tissue;

constexpr double kMm = 1e3, kMm2 = 1e6, kMm3 = 1e9;

// Series are aligned at no more than 25 Hz and 3000 samples, in a band of a tenth of their length:
// 1.8 million cells for ten minutes.
constexpr double kAlignRate_hz = 25;
constexpr size_t kAlignSamples = 3000;
constexpr size_t kBandShare = 10;

// Everything measured about one attempt; the registry below picks from it.
struct Measured {
  BoxVolume target, leeway, container;  // each box whole, the inner ones included
  std::array<double, cutting::kTissueCount> removed_m3{};
  double rms_m = 0, p95_m = 0;
  std::array<double, kPartCount> part_m{};
  double pulp_exposed_m2 = 0;
  double align_pose_m = 0, align_force_n = 0;
  const ProcessRecorder* process = nullptr;
};

double Percent(double part, double whole) { return whole > 0 ? 100 * part / whole : 0; }
double Removed(const Measured& m, Tissue t) { return m.removed_m3[static_cast<size_t>(t)] * kMm3; }

// A table and not a switch: what is measured, shown and named in a rubric is the same list.
struct Entry {
  MetricInfo info;
  double (*value)(const Measured&);
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
      "Root mean square distance to the reference surface, by area, where either was cut."},
     [](const Measured& m) { return m.rms_m * kMm; }},
    {{"deviation_p95_mm", "mm", "Largest deviations",
      "Distance to the reference surface that 95 % of the cut area stays within."},
     [](const Measured& m) { return m.p95_m * kMm; }},
    {{"wall_mesial_mm", "mm", "Mesial wall", "Median signed deviation of the mesial wall, by area.",
      "too deep", "short"},
     [](const Measured& m) { return m.part_m[kMesial] * kMm; }},
    {{"wall_distal_mm", "mm", "Distal wall", "Median signed deviation of the distal wall, by area.",
      "too deep", "short"},
     [](const Measured& m) { return m.part_m[kDistal] * kMm; }},
    {{"wall_buccal_mm", "mm", "Buccal wall", "Median signed deviation of the buccal wall, by area.",
      "too deep", "short"},
     [](const Measured& m) { return m.part_m[kBuccal] * kMm; }},
    {{"wall_lingual_mm", "mm", "Lingual wall",
      "Median signed deviation of the lingual wall, by area.", "too deep", "short"},
     [](const Measured& m) { return m.part_m[kLingual] * kMm; }},
    {{"floor_mm", "mm", "Floor", "Median signed deviation of the cavity's floor, by area.",
      "too deep", "too shallow"},
     [](const Measured& m) { return m.part_m[kFloor] * kMm; }},
    {{"removed_enamel_mm3", "mm3", "Enamel removed", "Volume of enamel that went."},
     [](const Measured& m) { return Removed(m, Tissue::kEnamel); }},
    {{"removed_dentin_mm3", "mm3", "Dentin removed", "Volume of dentin that went."},
     [](const Measured& m) { return Removed(m, Tissue::kDentin); }},
    {{"removed_pulp_mm3", "mm3", "Pulp removed", "Volume of pulp that went."},
     [](const Measured& m) { return Removed(m, Tissue::kPulp); }},
    {{"pulp_exposed_mm2", "mm2", "Pulp exposed",
      "Area of the final surface that is pulp and was not surface before."},
     [](const Measured& m) { return m.pulp_exposed_m2 * kMm2; }},
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

// Signed deviations of the parts' vertices of one surface, by area.
using PartValues = std::array<std::vector<WeightedValue>, kPartCount>;

constexpr double kOtherSurface = 2;  // a line may be so many times the nearest distance

// From the nearest distance to the distance along the wall's mean normal. Nearest distances to a
// rough wall end at whatever stands out of it, and so make a deep wall look shallower by its
// roughness; along one direction they are the two walls' heights. What the line meets farther off
// is another surface: then the nearest distance stands.
double AlongNormal_m(double nearest_m, const cutting::Volume& own, const cutting::Volume& other,
                     const dvec3& point_m, const dvec3& normal) {
  double h = own.spec().voxel_m();
  double reach = kOtherSurface * std::fabs(nearest_m) + h;
  double there = SurfaceAlong_m(other, point_m, normal, reach);
  // A vertex of the mesh lies near its own volume's surface, not on it: both ends of the line are
  // taken from volumes, so that the mesh's error drops out.
  double along = there - SurfaceAlong_m(own, point_m, normal, h);
  return std::fabs(there) < reach ? along : nearest_m;
}

void CollectParts(const AttemptData& cut, const AttemptData& other,
                  const std::vector<float>& deviation_m, const std::vector<double>& areas_m2,
                  const OpenBox& target, double depth_m, double sign, PartValues& parts) {
  const surface::Mesh& mesh = *cut.final_surface;
  std::array<std::vector<size_t>, kPartCount> vertices;
  std::array<dvec3, kPartCount> normal{};
  for (size_t i = 0; i < deviation_m.size(); ++i) {
    if (std::isnan(deviation_m[i])) continue;
    dvec3 facing(mesh.normal[i]);
    Part part = PartOf(target, depth_m, dvec3(mesh.position_m[i]), facing);
    if (part == kNoPart) continue;
    vertices[part].push_back(i);
    normal[part] += facing * areas_m2[i];
  }
  for (size_t p = 0; p < kPartCount; ++p) {
    double length = std::sqrt(Dot(normal[p], normal[p]));
    for (size_t i : vertices[p]) {
      double value = AlongNormal_m(deviation_m[i], *cut.final_volume, *other.final_volume,
                                   dvec3(mesh.position_m[i]), normal[p] / length);
      parts[p].push_back({sign * value, areas_m2[i]});
    }
  }
}

// Both ways, so that a wall that one of the two never cut still counts: the attempt's vertices
// against the reference's surface and the reference's against the attempt's.
void MeasureParts(const AttemptData& attempt, const std::vector<float>& deviation_m,
                  const std::vector<double>& areas_m2, const AttemptData& reference,
                  const OpenBox& target, double depth_m, Measured& out) {
  PartValues parts;
  CollectParts(attempt, reference, deviation_m, areas_m2, target, depth_m, 1, parts);
  std::vector<float> back =
      DeviationPerVertex(*reference.final_surface, *reference.initial, *reference.final_volume,
                         *attempt.final_volume, *attempt.final_surface);
  CollectParts(reference, attempt, back, VertexAreas_m2(*reference.final_surface), target, depth_m,
               -1, parts);
  for (size_t p = 0; p < kPartCount; ++p) {
    // Adding zero turns -0 into 0.
    out.part_m[p] = WeightedQuantile(std::move(parts[p]), 0.5) + 0.0;
  }
}

void MeasureDeviation(const std::vector<float>& deviation_m, const std::vector<double>& areas_m2,
                      Measured& out) {
  std::vector<WeightedValue> sizes;
  double squares = 0, area = 0;
  for (size_t i = 0; i < deviation_m.size(); ++i) {
    if (std::isnan(deviation_m[i])) continue;
    double d = std::fabs(static_cast<double>(deviation_m[i]));
    squares += areas_m2[i] * d * d;
    area += areas_m2[i];
    sizes.push_back({d, areas_m2[i]});
  }
  out.rms_m = area > 0 ? std::sqrt(squares / area) : 0;
  out.p95_m = WeightedQuantile(std::move(sizes), 0.95);
}

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

// Means of `stride` samples: the position of the first, the mean force.
std::vector<PathSample> Resample(const std::vector<PathSample>& samples, size_t stride) {
  std::vector<PathSample> out;
  for (size_t i = 0; i < samples.size(); i += stride) {
    size_t end = std::min(i + stride, samples.size());
    PathSample s = samples[i];
    for (size_t k = i + 1; k < end; ++k) s.force_n += samples[k].force_n;
    s.force_n /= static_cast<double>(end - i);
    out.push_back(s);
  }
  return out;
}

double Distance(const dvec3& a, const dvec3& b) { return std::sqrt(Dot(a - b, a - b)); }

void MeasureAlignment(const ProcessRecorder& attempt, const ProcessRecorder& reference,
                      Measured& out) {
  size_t longest = std::max(attempt.samples().size(), reference.samples().size());
  double step_s = longest > 1 && attempt.samples().size() > 1
                      ? attempt.samples()[1].time_s - attempt.samples()[0].time_s
                      : 1 / kAlignRate_hz;
  size_t stride = 1;
  while (longest > stride * kAlignSamples ||
         // 0.999: two steps of 0.02 s are 25 Hz even if their sum is a hair short.
         static_cast<double>(stride) * step_s * kAlignRate_hz < 0.999) {
    ++stride;
  }
  // One stride for both, or a slow attempt would be compared at another step than its reference.
  auto a = Resample(attempt.samples(), stride), b = Resample(reference.samples(), stride);
  size_t band = std::max<size_t>(1, std::max(a.size(), b.size()) / kBandShare);
  out.align_pose_m = AlignBanded(a.size(), b.size(), band, [&](size_t i, size_t j) {
                       return Distance(a[i].anchor_m, b[j].anchor_m);
                     }).mean_cost;
  out.align_force_n = AlignBanded(a.size(), b.size(), band, [&](size_t i, size_t j) {
                        return Distance(a[i].force_n, b[j].force_n);
                      }).mean_cost;
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

Result<std::vector<MetricValue>> ComputeMetrics(const scene::Scene& scene,
                                                const scene::Exercise& exercise,
                                                const AttemptData& attempt,
                                                const AttemptData& reference,
                                                const std::function<void(double)>& progress) {
  auto tell = [&](double done) {
    if (progress) progress(done);
  };
  ENAMEL_RETURN_IF_ERROR(CheckInputs(attempt, reference));
  auto boxes = BoxesOf(scene, exercise.target);
  if (!boxes) return boxes.status();

  Measured m;
  m.process = attempt.process;
  m.target = MeasureBox(*attempt.initial, *attempt.final_volume, boxes->target);
  if (m.target.solid_m3 <= 0) {
    return Status(Code::kInvalidInput,
                  "the exercise's target holds no solid in scene \"" + scene.name +
                      "\": move its landmark or make it deeper",
                  "target");
  }
  m.leeway = MeasureBox(*attempt.initial, *attempt.final_volume, boxes->leeway);
  m.container = MeasureBox(*attempt.initial, *attempt.final_volume, boxes->container);
  m.removed_m3 = RemovedPerTissue_m3(*attempt.initial, *attempt.final_volume);
  tell(0.2);

  std::vector<float> own;
  if (!attempt.deviation_m) {
    own = DeviationPerVertex(*attempt.final_surface, *attempt.initial, *attempt.final_volume,
                             *reference.final_volume, *reference.final_surface);
  }
  const std::vector<float>& deviation = attempt.deviation_m ? *attempt.deviation_m : own;
  std::vector<double> areas = VertexAreas_m2(*attempt.final_surface);
  MeasureDeviation(deviation, areas, m);
  tell(0.5);
  MeasureParts(attempt, deviation, areas, reference, boxes->target, exercise.target.depth_um * 1e-6,
               m);
  m.pulp_exposed_m2 = PulpExposed_m2(attempt, areas);
  tell(0.8);
  MeasureAlignment(*attempt.process, *reference.process, m);
  tell(1);

  std::vector<MetricValue> out;
  for (const Entry& entry : kRegistry) {
    out.push_back({std::string(entry.info.name), entry.value(m), std::string(entry.info.unit)});
  }
  return out;
}

}  // namespace enamel::scoring
