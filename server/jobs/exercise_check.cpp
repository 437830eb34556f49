#include "server/jobs/exercise_check.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "common/scene/json/json.h"
#include "common/scene/plan.h"
#include "common/scene/preparation.h"
#include "common/scene/volume_blob.h"
#include "common/scoring/crown.h"
#include "common/scoring/score.h"
#include "common/scoring/zones.h"
#include "server/jobs/rubric_check.h"

namespace enamel::server {
namespace {

using cutting::Tissue;
using Outline = scene::PreparationPart::Outline;

constexpr double kMm3PerCubicMetre = 1e9;
// Of the pulp in the target: what voxels of 0.1 mm leave open.
constexpr double kMaxPulp_mm3 = 0.05;

Status Refused(const std::string& field, const std::string& expected, const std::string& found) {
  return Status(Code::kInvalidInput, "expected " + expected + ", found " + found, field);
}

std::string Mm(int64_t um) { return fmt::format("{} mm", static_cast<double>(um) / 1000); }

bool Has(const scene::Scene& scene, Tissue tissue) {
  return std::ranges::find(scene.tissues, tissue, &scene::TissueSpec::tissue) !=
         scene.tissues.end();
}

// A bur enters where its width fits. It passes around stumps; polygons are narrow somewhere.
Status CheckBur(const scene::Exercise& exercise) {
  std::vector<std::array<int32_t, 2>> halves;
  const scene::CavityTarget& target = exercise.target;
  for (const scene::PreparationPart& part : target.parts) {
    if (part.outline == Outline::kBox || part.outline == Outline::kDisc)
      halves.push_back(part.half_size_um);
  }
  if (target.parts.empty()) halves.push_back({target.half_size_um[0], target.half_size_um[1]});
  for (const auto& half : halves) {
    const int32_t narrow = std::min(half[0], half[1]);
    if (exercise.bur_radius_um > narrow) {
      return Refused("bur.radius_um",
                     "a bur that fits into the target, which is " + Mm(int64_t{2} * narrow) +
                         " wide at its narrowest part",
                     "one of " + Mm(int64_t{2} * exercise.bur_radius_um));
    }
  }
  return Status::Ok();
}

// What the scene cannot give is left out of the score without a word; who asks for it should hear.
Status CheckMetric(const scene::Scene& scene, const scene::Exercise& exercise,
                   const std::string& metric, const std::string& field) {
  const std::string_view name = metric;
  if (name.starts_with("caries_") && !Has(scene, Tissue::kCaries)) {
    return Refused(field, "a tooth with caries for " + metric,
                   "\"" + scene.name + "\", which has none");
  }
  const bool of_neighbour = name.starts_with("neighbour_") || name == "contact_left_percent";
  if (of_neighbour && !Has(scene, Tissue::kNeighbour)) {
    return Refused(field, "a tooth with neighbours for " + metric,
                   "\"" + scene.name + "\", which has none");
  }
  const bool of_crown = name.starts_with("convergence_") || name.starts_with("crown_") ||
                        name.starts_with("finish_") || name.starts_with("reduction_") ||
                        name.starts_with("bevel_");
  if (of_crown && !scoring::IsCrown(exercise.target)) {
    return Refused(field, "a target that leaves a stump for " + metric, "a cavity");
  }
  return Status::Ok();
}

Status CheckMetrics(const scene::Scene& scene, const scene::Exercise& exercise) {
  const auto& critical = exercise.rubric.critical;
  for (size_t i = 0; i < critical.size(); ++i) {
    ENAMEL_RETURN_IF_ERROR(CheckMetric(scene, exercise, critical[i].metric,
                                       "rubric.critical[" + std::to_string(i) + "].metric"));
  }
  return Status::Ok();
}

// The kinds of region that a cavity, a stump and a cut surface without walls have. Work on a region
// without a price cannot be scored. The regions themselves are known only once a tooth is cut.
constexpr std::array<std::string_view, 3> kOfCavity = {"floor", "wall", "line_angle"};
constexpr std::array<std::string_view, 4> kOfStump = {"table", "axial_wall", "margin",
                                                      "line_angle"};
constexpr std::array<std::string_view, 2> kOfFace = {"face", "line_angle"};

Status CheckPrices(const scene::Exercise& exercise) {
  auto has = [&](const auto& kinds) {
    return std::ranges::all_of(kinds, [&](std::string_view kind) {
      const auto& prices = exercise.rubric.prices;
      return std::ranges::find(prices, kind, &scene::RubricPrice::of) != prices.end();
    });
  };
  const bool is_prepared = !exercise.target.prepared.IsZero();
  const bool is_stump = scoring::IsCrown(exercise.target) && !is_prepared;
  if (has(kOfStump) || (!is_stump && (has(kOfCavity) || has(kOfFace)))) return Status::Ok();
  std::string expected = is_stump ? ""
                                  : fmt::format("{}, or {}, or ", fmt::join(kOfCavity, ", "),
                                                fmt::join(kOfFace, ", "));
  expected += fmt::format("{}", fmt::join(kOfStump, ", "));
  return Refused("rubric.prices", "prices of all kinds of region that the target has: " + expected,
                 fmt::format("prices of {} kinds without these", exercise.rubric.prices.size()));
}

// How far the tooth itself reaches along x and y, by whole bricks, m.
std::array<double, 2> ExtentOf_m(const cutting::Volume& volume) {
  const cutting::GridSpec& spec = volume.spec();
  ivec3 lo(spec.bricks), hi(-1);
  for (int z = 0; z < spec.bricks.z; ++z)
    for (int y = 0; y < spec.bricks.y; ++y)
      for (int x = 0; x < spec.bricks.x; ++x) {
        const int brick = spec.BrickIndex({x, y, z});
        const Tissue tissue = volume.UniformTissue(brick);
        const bool is_solid = volume.IsStored(brick) || tissue != Tissue::kAir;
        const bool is_neighbour = !volume.HasLabels(brick) && tissue == Tissue::kNeighbour;
        if (!is_solid || is_neighbour) continue;
        lo = {std::min(lo.x, x), std::min(lo.y, y), std::min(lo.z, z)};
        hi = {std::max(hi.x, x), std::max(hi.y, y), std::max(hi.z, z)};
      }
  const double edge_m = spec.voxel_m() * cutting::kBrickSide;
  return {(hi.x - lo.x + 1) * edge_m, (hi.y - lo.y + 1) * edge_m};
}

Status CheckVolume(const scene::Scene& scene, const scene::Exercise& exercise,
                   const cutting::Volume& volume) {
  const scene::CavityTarget& target = exercise.target;
  const auto extent = ExtentOf_m(volume);
  for (size_t i = 0; i < 2; ++i) {
    const double width_m = 2e-6 * target.half_size_um[i];
    if (!scoring::IsCrown(target) && width_m > extent[i]) {
      return Refused("target.half_size_um",
                     fmt::format("a target no wider than the tooth, {:.1f} mm along {}",
                                 extent[i] * 1e3, i == 0 ? "x" : "y"),
                     fmt::format("{:.1f} mm", width_m * 1e3));
    }
  }
  const bool opening_fails = std::ranges::any_of(
      exercise.rubric.critical,
      [](const scene::RubricCritical& critical) { return critical.metric == "pulp_exposed_mm2"; });
  if (!opening_fails) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(const auto shape, scene::TargetShape(scene, target));
  const auto gone = scoring::RemovedPerTissue_m3(volume, scene::Prepared(volume, shape));
  const double pulp_mm3 = gone[static_cast<size_t>(Tissue::kPulp)] * kMm3PerCubicMetre;
  if (pulp_mm3 <= kMaxPulp_mm3) return Status::Ok();
  return Refused("target.depth_um",
                 "a target that leaves the pulp closed, as an open pulp fails the attempt",
                 fmt::format("one that takes {:.2f} mm3 of it at {}", pulp_mm3,
                             Mm(target.depth_um) + " depth"));
}

// The number right before `words`, in mm: "2.5" of "2.5 mm deep".
std::optional<double> NumberBefore(std::string_view text, size_t at) {
  size_t first = at;
  while (first > 0 &&
         ((text[first - 1] >= '0' && text[first - 1] <= '9') || text[first - 1] == '.'))
    --first;
  if (first == at) return std::nullopt;
  const std::string number(text.substr(first, at - first));
  return std::strtod(number.c_str(), nullptr);
}

// "the text says 3 mm deep, the target is 2 mm deep".
std::vector<std::string> ContradictingSizes(const scene::Exercise& exercise) {
  constexpr double kSame_mm = 0.05;
  std::vector<std::string> out;
  const scene::CavityTarget& target = exercise.target;
  // A floor that follows the tooth, or parts of several depths, has no one depth.
  if (!target.parts.empty() || !target.prepared.IsZero()) return out;
  const std::string_view text = exercise.instructions;
  constexpr std::string_view kDeep = " mm deep";
  for (size_t at = text.find(kDeep); at != std::string_view::npos; at = text.find(kDeep, at + 1)) {
    const auto said_mm = NumberBefore(text, at);
    const double is_mm = target.depth_um * 1e-3;
    if (!said_mm || std::abs(*said_mm - is_mm) <= kSame_mm) continue;
    out.push_back(
        fmt::format("the text says {} mm deep, the target is {} mm deep", *said_mm, is_mm));
  }
  return out;
}

// None where it is not stored: another check finds that out.
std::optional<scene::Scene> SceneOf(StoredBlobs& blobs, const scene::Exercise& exercise) {
  const auto text = blobs.GetBlob(exercise.scene);
  if (!text.ok()) return std::nullopt;
  auto scene = scene::SceneFromJson(AsText(*text));
  if (!scene.ok()) return std::nullopt;
  return std::move(*scene);
}

}  // namespace

Status CheckExercise(StoredBlobs& blobs, const scene::Exercise& exercise) {
  auto in_rubric = [](const Status& status) {
    return Status(status.code(), status.message(), "rubric." + status.field());
  };
  if (Status rubric = scoring::ValidateRubric(exercise.rubric); !rubric.ok()) {
    return in_rubric(rubric);
  }
  ENAMEL_RETURN_IF_ERROR(CheckPrices(exercise));
  if (Status words = CheckRubricWords(exercise.rubric); !words.ok()) return in_rubric(words);
  if (exercise.time_limit_s != 0 && exercise.time_limit_s < kMinTime_s) {
    return Refused("time_limit_s", "none (0) or at least " + std::to_string(kMinTime_s) + " s",
                   std::to_string(exercise.time_limit_s) + " s");
  }
  ENAMEL_RETURN_IF_ERROR(CheckBur(exercise));
  const auto scene = SceneOf(blobs, exercise);
  if (!scene) return Status::Ok();
  if (Status found = scene::TargetPoint(*scene, exercise.target).status(); !found.ok()) {
    std::string known;
    for (const auto& [name, point] : scene->landmarks) known += (known.empty() ? "" : ", ") + name;
    return Refused("target.landmark", "a landmark of \"" + scene->name + "\": " + known,
                   "\"" + exercise.target.landmark + "\"");
  }
  ENAMEL_RETURN_IF_ERROR(CheckMetrics(*scene, exercise));
  if (exercise.graded) {
    if (const auto coarse = scene::WhyTooCoarse(exercise, scene->voxel_nm))
      return Status(Code::kInvalidInput, *coarse, "bur.radius_um");
  }
  if (!exercise.target.prepared.IsZero()) return Status::Ok();
  const auto blob = blobs.GetBlob(scene->volume);
  if (!blob.ok()) return Status::Ok();
  const auto volume = scene::DecodeVolume(*blob);
  if (!volume.ok()) return Status::Ok();
  return CheckVolume(*scene, exercise, *volume);
}

std::vector<std::string> ExerciseWarnings(StoredBlobs& blobs, const scene::Exercise& exercise) {
  std::vector<std::string> out = ContradictingSizes(exercise);
  const auto scene = SceneOf(blobs, exercise);
  if (!scene) return out;
  if (const auto coarse = scene::WhyTooCoarse(exercise, scene->voxel_nm)) out.push_back(*coarse);
  return out;
}

}  // namespace enamel::server
