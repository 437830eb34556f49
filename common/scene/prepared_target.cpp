#include "common/scene/prepared_target.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "common/scene/json/json.h"
#include "common/scene/volume_blob.h"

namespace enamel::scene {
namespace {

using cutting::kBrickSide;
using cutting::kBrickVoxels;
using cutting::SolidFraction;
using cutting::Volume;

// Less than this share of a voxel is rounding.
constexpr int32_t kMinFraction = 655;
// A tooth that went through a mesh may have a sample that lies a little higher.
constexpr int32_t kMaxGrown = 6554;

Status Refuse(const std::string& what) {
  return Status(Code::kInvalidInput, what, "target.prepared_scene_sha256");
}

Result<std::shared_ptr<const PreparedTooth>> Compare(const Volume& initial, Volume prepared) {
  const cutting::GridSpec& spec = initial.spec();
  if (!(spec == prepared.spec())) {
    return Status(Code::kConflict,
                  "the target's prepared tooth has other voxels than the exercise's tooth: make it "
                  "from that tooth again",
                  "target.prepared_scene_sha256");
  }
  auto out = std::make_shared<PreparedTooth>();
  ivec3 lo(std::numeric_limits<int>::max()), hi(-1);
  for (int b = 0; b < spec.brick_count(); ++b) {
    if (!initial.IsStored(b) && !prepared.IsStored(b) &&
        initial.UniformTissue(b) == prepared.UniformTissue(b)) {
      continue;
    }
    const ivec3 first = ivec3(b % spec.bricks.x, b / spec.bricks.x % spec.bricks.y,
                              b / (spec.bricks.x * spec.bricks.y)) *
                        kBrickSide;
    for (int i = 0; i < kBrickVoxels; ++i) {
      const ivec3 v = first + ivec3(i & 7, i >> 3 & 7, i >> 6);
      const int32_t gone = SolidFraction(initial.PhiAt(v)) - SolidFraction(prepared.PhiAt(v));
      if (gone < -kMaxGrown) {
        return Refuse("the target's prepared tooth has solid where the exercise's tooth has none");
      }
      if (gone < kMinFraction) continue;
      lo = glm::min(lo, v), hi = glm::max(hi, v);
    }
  }
  if (hi.x < 0) return Refuse("of the target's prepared tooth nothing has to go");
  out->lo_m = spec.origin_m() + (dvec3(lo) - 0.5) * spec.voxel_m();
  out->hi_m = spec.origin_m() + (dvec3(hi) + 0.5) * spec.voxel_m();
  out->volume = std::move(prepared);
  return std::shared_ptr<const PreparedTooth>(std::move(out));
}

int32_t UpUm(double m) { return static_cast<int32_t>(std::ceil(m * 1e6 - 1e-3)); }

// The box about the landmark that holds what has to go.
CavityTarget BoxAbout(const PointUm& at, const PreparedTooth& tooth) {
  CavityTarget out;
  for (size_t i = 0; i < 2; ++i) {
    const auto axis = static_cast<int>(i);
    out.half_size_um[i] = std::max(UpUm(tooth.hi_m[axis]) - at[i], at[i] + UpUm(-tooth.lo_m[axis]));
  }
  out.depth_um = at[2] + UpUm(-tooth.lo_m.z);
  return out;
}

}  // namespace

Status LoadPreparedTarget(const Volume& initial, const FetchContent& fetch, CavityTarget& target) {
  if (target.prepared.IsZero()) return Status::Ok();
  ENAMEL_ASSIGN_OR_RETURN(auto text, fetch(target.prepared));
  ENAMEL_ASSIGN_OR_RETURN(auto scene, SceneFromJson(AsText(text)));
  ENAMEL_ASSIGN_OR_RETURN(auto blob, fetch(scene.volume));
  ENAMEL_ASSIGN_OR_RETURN(auto volume, DecodeVolume(blob));
  ENAMEL_ASSIGN_OR_RETURN(auto tooth, Compare(initial, std::move(volume)));
  // The landmark is not known here, and the box is symmetric about it: its size alone is compared.
  const dvec3 size_m = tooth->hi_m - tooth->lo_m;
  for (int i = 0; i < 2; ++i) {
    if (UpUm(size_m[i]) <= 2 * target.half_size_um[static_cast<size_t>(i)]) continue;
    return Refuse("the target's box is smaller than what has to go of its prepared tooth");
  }
  target.prepared_tooth = std::move(tooth);
  return Status::Ok();
}

Result<CavityTarget> TargetFromPrepared(const Scene& scene, const Volume& initial, Volume prepared,
                                        const Sha256& prepared_scene, int32_t tolerance_um) {
  ENAMEL_ASSIGN_OR_RETURN(auto tooth, Compare(initial, std::move(prepared)));
  std::optional<CavityTarget> best;
  auto size = [](const CavityTarget& t) {
    return double{1} * t.half_size_um[0] * t.half_size_um[1] * t.depth_um;
  };
  for (const auto& [name, at] : scene.landmarks) {
    CavityTarget box = BoxAbout(at, *tooth);
    if (box.depth_um <= 0 || (best && size(*best) <= size(box))) continue;
    box.landmark = name;
    best = std::move(box);
  }
  if (!best) return Refuse("the scene has no landmark above what has to go");
  best->leeway_side_um = best->leeway_bottom_um = best->container_um = tolerance_um;
  best->prepared = prepared_scene;
  best->prepared_tooth = std::move(tooth);
  return *std::move(best);
}

}  // namespace enamel::scene
