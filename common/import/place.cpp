#include "common/import/place.h"

#include <algorithm>
#include <cmath>

#include "common/import/stance.h"
#include "common/import/tooth_size.h"
#include "common/mesh/orient.h"
#include "common/mesh/units.h"

namespace enamel::import {
namespace {

constexpr double kDegrees = 57.29577951308232;
constexpr double kLeastRise = 0.03;  // of the enamel's extent, to tell a direction by it
constexpr double kOnAxis = 0.866;    // 30 degrees

size_t LongestAxis(const dvec3& v) {
  const dvec3 a = glm::abs(v);
  return a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
}

// "+y of the file, 12 degrees off".
std::string AxisName(const dvec3& up) {
  const auto k = static_cast<int>(LongestAxis(up));
  const std::string name = std::string(up[k] > 0 ? "+" : "-") + "xyz"[k] + " of the file";
  const auto degrees = std::lround(std::acos(std::min(std::abs(up[k]), 1.0)) * kDegrees);
  return degrees == 0 ? name : name + ", " + std::to_string(degrees) + " degrees off";
}

std::string Explain(const mesh::Stance& stance, const std::string& up, const std::string& how) {
  const std::string axis = "occlusal direction " + AxisName(stance.up);
  if (up != "auto") return axis + " (as given)";
  if (stance.certain)
    return axis + " (found by " + how + "; if it is wrong, give another with --up)";
  return axis + " (a guess" + (how.empty() ? "" : " by " + how) +
         ": look at the tooth, and give the direction with --up, for example --up=-y)";
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
  if (size < kLeastRise * extent) return std::nullopt;
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

struct Turned {
  dmat3 turn{1};
  std::string words;
};
Result<Turned> TurnOf(const mesh::Triangles& crown, const dvec3& up, const Facing& facing) {
  if (facing.buccal == "auto") {
    const ToothSize& mean = MeanSize(facing.tooth);
    return Turned{mesh::SceneFromFile(crown, up, mean.mesiodistal_mm > mean.buccolingual_mm),
                  "buccal is taken to be at +y: a mesh does not say it (give its direction in the "
                  "file with --buccal)"};
  }
  Result<dvec3> axis = mesh::ParseAxis(facing.buccal);
  if (!axis.ok()) return Status(axis.status().code(), axis.status().message(), "buccal");
  if (std::abs(Dot(*axis, up)) > kOnAxis) {
    return Status(Code::kInvalidInput,
                  "expected a buccal direction across the occlusal one, " + AxisName(up) +
                      "; found " + facing.buccal,
                  "buccal");
  }
  return Turned{mesh::SceneFacing(up, *axis),
                "buccal direction " + AxisName(*axis) + " (as given)"};
}

}  // namespace

Result<PlacedSolid> Place(mesh::Solid solid, const Facing& facing) {
  mesh::Stance stance;
  std::string how;
  if (facing.up == "auto") {
    FoundStance found = FindStance(solid, facing.tooth);
    stance = found.stance;
    how = std::move(found.by);
  } else {
    Result<dvec3> axis = mesh::ParseAxis(facing.up);
    if (!axis.ok()) return axis.status();
    stance = mesh::StanceWithUp(solid.mesh, *axis);
  }
  ENAMEL_ASSIGN_OR_RETURN(const Turned turned, TurnOf(solid.mesh, stance.up, facing));
  Move(solid, turned.turn, MiddleOf(solid.mesh, turned.turn));
  PlacedSolid placed{
      std::move(solid), std::nullopt, {Explain(stance, facing.up, how), turned.words}};
  if (stance.gum) placed.gum = turned.turn * *stance.gum;
  return placed;
}

Result<PlacedLayers> Place(LayerSolids layers, const Facing& facing) {
  const auto& enamel = layers.solids[static_cast<size_t>(Layer::kEnamel)];
  const auto& dentin = layers.solids[static_cast<size_t>(Layer::kDentin)];
  const mesh::Solid& outer = enamel ? *enamel : *dentin;
  const mesh::Triangles crown = outer.mesh;
  mesh::Stance stance;
  std::string how = "the enamel's place on the dentin";
  if (facing.up != "auto") {
    Result<dvec3> axis = mesh::ParseAxis(facing.up);
    if (!axis.ok()) return axis.status();
    stance.up = *axis;
  } else if (auto by_rise = StanceByRise(layers, mesh::BoxOf(crown).extent())) {
    stance = *by_rise;
  } else {
    FoundStance found = FindStance(outer, facing.tooth);
    stance = found.stance;
    how = std::move(found.by);
  }
  ENAMEL_ASSIGN_OR_RETURN(const Turned turned, TurnOf(crown, stance.up, facing));
  const dvec3 middle = MiddleOf(crown, turned.turn);
  for (auto& solid : layers.solids) {
    if (solid) Move(*solid, turned.turn, middle);
  }
  return PlacedLayers{std::move(layers), {Explain(stance, facing.up, how), turned.words}};
}

}  // namespace enamel::import
