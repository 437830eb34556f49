#include "station/mouth/antagonist.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "common/scene/tooth_number.h"
#include "station/mouth/crowns.h"
#include "station/mouth/gingiva.h"

namespace enamel::station::mouth {
namespace {

// They are in the picture only where it shows some three times a tooth's width.
constexpr int32_t kVoxel_nm = 400'000;
// In occlusion the cusps reach into the opposite fossae; the incisors' overbite is about as much.
constexpr double kOverlap_mm = 2;
// From the hinge axis to the incisors, Bonwill's triangle of 4 inches; and less by so much for each
// tooth farther back, whose distance along the arch is not all toward the hinge.
constexpr double kBonwill_mm = 101.6, kPerPlace_mm = 5.5;

// From the opposite tooth's frame, which is turned over about the buccolingual axis, to this one's.
// The jaws turn about a hinge on the level of the crown's top: behind a front tooth, distal of others.
glm::dmat4 FromOpposite(int tooth, double top_mm, double opposite_top_mm) {
  const glm::dmat4 turned_over = glm::rotate(
      glm::translate(glm::dmat4(1), glm::dvec3(0, 0, top_mm + opposite_top_mm - kOverlap_mm)),
      std::numbers::pi, glm::dvec3(0, 1, 0));
  const double angle = 2 * std::asin(0.5 * kOpening_mm / kBonwill_mm),
               away = kBonwill_mm - kPerPlace_mm * (tooth % 10 - 1);
  const bool anterior = scene::IsAnterior(tooth);
  const double mesial = scene::MesialX(tooth);
  const glm::dvec3 hinge =
      anterior ? glm::dvec3(0, -away, top_mm) : glm::dvec3(-mesial * away, 0, top_mm);
  const glm::dvec3 axis = anterior ? glm::dvec3(1, 0, 0) : glm::dvec3(0, -mesial, 0);
  return glm::translate(glm::rotate(glm::translate(glm::dmat4(1), hinge), angle, axis), -hinge) *
         turned_over;
}

void Move(const glm::dmat4& to, render::GroupMesh& mesh) {
  for (render::GpuVertex& v : mesh.vertices) {
    const glm::dvec4 p = to * glm::dvec4(v.position_mm[0], v.position_mm[1], v.position_mm[2], 1);
    const glm::dvec4 n = to * glm::dvec4(v.normal[0], v.normal[1], v.normal[2], 0);
    for (int i = 0; i < 3; ++i) {
      v.position_mm[i] = static_cast<float>(p[i]);
      v.normal[i] = static_cast<int8_t>(std::lround(n[i]));
    }
  }
}

}  // namespace

std::vector<render::GroupMesh> AntagonistOf(int tooth, double top_mm) {
  const int quadrant = tooth / 10;
  if (quadrant > 4) return {};
  const std::vector<Crown> row = RowOf((5 - quadrant) * 10 + tooth % 10);
  std::vector<Neck> necks;
  std::vector<render::GroupMesh> out;
  for (const Crown& crown : row) {
    necks.push_back(crown.neck());
    out.push_back(crown.Mesh(kVoxel_nm));
  }
  constexpr double kNoLimit_mm = 1e3;
  for (render::GroupMesh& piece : Gingiva(std::move(necks), Around(kNoLimit_mm)).Pieces()) {
    out.push_back(std::move(piece));
  }
  const glm::dmat4 to = FromOpposite(tooth, top_mm, row[0].shape.hi.z);
  for (render::GroupMesh& mesh : out) Move(to, mesh);
  return out;
}

}  // namespace enamel::station::mouth
