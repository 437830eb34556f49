#include "common/import/place.h"

#include <algorithm>
#include <cmath>

#include "common/import/stance.h"
#include "common/import/tooth_size.h"
#include "common/mesh/orient.h"
#include "common/mesh/units.h"

namespace enamel::import {
namespace {

constexpr double kMinRise = 0.03;  // of the enamel's extent, to tell a direction by it
constexpr double kOnAxis = 0.866;  // 30 degrees

size_t LongestAxis(const dvec3& v) {
  const dvec3 a = glm::abs(v);
  return a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
}

void Move(mesh::Solid& solid, const dmat3& turn, const dvec3& middle) {
  for (mesh::Triangles* mesh : {&solid.mesh, &solid.boundary, &solid.hollows}) {
    for (dvec3& v : mesh->vertices) v = turn * v - middle;
  }
}

dvec3 MiddleOf(const mesh::Triangles& mesh, const dmat3& turn) {
  // The box of the turned mesh, which is not the turned box.
  mesh::Triangles turned = mesh;
  for (dvec3& v : turned.vertices) v = turn * v;
  const mesh::Box box = mesh::BoxOf(turned);
  return 0.5 * (box.lo + box.hi);
}

// By the way from dentin to enamel; nothing where they have one middle.
std::optional<mesh::Stance> StanceByRise(const LayerSolids& layers, double extent) {
  const dvec3 rise = RiseOf(layers);
  const double size = std::sqrt(Dot(rise, rise));
  if (size < kMinRise * extent) return std::nullopt;
  mesh::Stance stance;
  stance.up = rise / size;
  const auto k = static_cast<int>(LongestAxis(rise));
  // A cap's middle leans to where it is thicker, so the way to it is no better than this: near a
  // file's axis the axis is taken.
  if (std::abs(stance.up[k]) > kOnAxis) {
    const double sign = rise[k] > 0 ? 1 : -1;
    stance.up = dvec3(0);
    stance.up[k] = sign;
  }
  return stance;
}

// Rows as mesh::SceneFromFile's.
Result<dmat3> TurnOf(const mesh::Triangles& crown, const dvec3& up, const Facing& facing) {
  if (facing.buccal == "auto") {
    const ToothSize& mean = MeanSize(facing.tooth);
    return mesh::SceneFromFile(crown, up, mean.mesiodistal_mm > mean.buccolingual_mm);
  }
  ENAMEL_ASSIGN_OR_RETURN(const dvec3 buccal, mesh::ParseDirection(facing.buccal));
  if (std::abs(Dot(buccal, up)) > kOnAxis) {
    return Status(Code::kInvalidInput,
                  "expected a buccal direction across the occlusal one, found two less than 30 "
                  "degrees apart",
                  "buccal");
  }
  return mesh::SceneFacing(up, buccal);
}

Placement PlacementOf(const dmat3& turn, const mesh::Stance& stance, std::vector<Witness> by,
                      const Facing& facing) {
  const dmat3 axes = glm::transpose(turn);
  return {axes[2], axes[1],
          facing.up != "auto" ? Placement::Up::kGiven
          : stance.certain    ? Placement::Up::kFound
                              : Placement::Up::kGuess,
          std::move(by), facing.buccal != "auto"};
}

}  // namespace

Status CheckFacing(const Facing& facing) {
  if (facing.up != "auto") ENAMEL_RETURN_IF_ERROR(mesh::ParseDirection(facing.up).status());
  if (facing.buccal == "auto") return Status::Ok();
  const Status buccal = mesh::ParseDirection(facing.buccal).status();
  return buccal.ok() ? buccal : Status(buccal.code(), buccal.message(), "buccal");
}

Result<PlacedSolid> Place(mesh::Solid solid, const Facing& facing) {
  ENAMEL_RETURN_IF_ERROR(CheckFacing(facing));
  FoundStance found;
  if (facing.up == "auto") {
    found = FindStance(solid, facing.tooth);
  } else {
    ENAMEL_ASSIGN_OR_RETURN(const dvec3 up, mesh::ParseDirection(facing.up));
    found.stance = mesh::StanceWithUp(solid.mesh, up);
  }
  // A scan ends at the gum: there is nothing to recognise where it has a hole below.
  constexpr double kBelow = 0.5;
  mesh::Stance& stance = found.stance;
  if (const auto hole = HoleOf(solid); hole && Dot(*hole, stance.up) < -kBelow) stance.gum = hole;
  ENAMEL_ASSIGN_OR_RETURN(const dmat3 turn, TurnOf(solid.mesh, stance.up, facing));
  const dvec3 middle = MiddleOf(solid.mesh, turn);
  Move(solid, turn, middle);
  PlacedSolid placed{std::move(solid), std::nullopt,
                     PlacementOf(turn, stance, std::move(found.by), facing), turn, middle};
  if (stance.gum) placed.gum = turn * *stance.gum;
  return placed;
}

Result<PlacedLayers> Place(LayerSolids layers, const Facing& facing) {
  ENAMEL_RETURN_IF_ERROR(CheckFacing(facing));
  const auto& enamel = layers.solids[static_cast<size_t>(Layer::kEnamel)];
  const auto& dentin = layers.solids[static_cast<size_t>(Layer::kDentin)];
  const mesh::Solid& outer = enamel ? *enamel : *dentin;
  const mesh::Triangles crown = outer.mesh;
  FoundStance found;
  if (facing.up != "auto") {
    ENAMEL_ASSIGN_OR_RETURN(found.stance.up, mesh::ParseDirection(facing.up));
  } else if (auto by_rise = StanceByRise(layers, mesh::BoxOf(crown).extent())) {
    found = {*by_rise, {Witness::kEnamel}};
  } else {
    found = FindStance(outer, facing.tooth);
  }
  ENAMEL_ASSIGN_OR_RETURN(const dmat3 turn, TurnOf(crown, found.stance.up, facing));
  const dvec3 middle = MiddleOf(crown, turn);
  for (auto& solid : layers.solids) {
    if (solid) Move(*solid, turn, middle);
  }
  return PlacedLayers{std::move(layers),
                      PlacementOf(turn, found.stance, std::move(found.by), facing)};
}

}  // namespace enamel::import
