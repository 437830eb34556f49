#include "station/mouth/crowns.h"

#include <cmath>

#include "common/scene/builder.h"
#include "common/scene/builtin/teeth.h"
#include "common/scene/tooth_number.h"
#include "common/surface/surface.h"

namespace enamel::station::mouth {
namespace {

// Crowns' mesiodistal widths and buccolingual depths, mm, by the place from the middle: of the table
// that the built-in teeth follow (common/scene/builtin/teeth.h).
constexpr double kUpper[8][2] = {{8.5, 7}, {6.5, 6}, {7.5, 8}, {7, 9},
                                 {7, 9},   {10, 11}, {9, 11},  {8.5, 10}};
constexpr double kLower[8][2] = {{5, 6}, {5.5, 6.5}, {7, 7.5},   {7, 7.5},
                                 {7, 8}, {11, 10.5}, {10.5, 10}, {10, 9.5}};

constexpr double kGap_mm = 0.05;
// Of the arch: about that of its front, and of its side, which is nearly straight.
constexpr double kFrontRadius_mm = 27, kSideRadius_mm = 80;
constexpr int kEachSide = 2;
// How far below its cement line a crown is drawn: the gingiva hides the rest.
constexpr double kBelowCementLine_mm = 2.5;

// Stand-ins: canines are incisors with a tip, upper molars have the lower one's crown.
scene::ToothShape ShapeOf(int tooth) {
  const int place = tooth % 10;
  scene::ToothShape out = place <= 3   ? scene::UpperCentralIncisor()
                          : place <= 5 ? scene::UpperFirstPremolar()
                                       : scene::LowerFirstMolar();
  out.fdi = tooth;
  // Its edge falls by a millimetre to either side.
  if (place == 3) out.ridges.at(0).weight_x = 0.14;
  return out;
}

glm::dvec2 SizeOf(int tooth) {
  const auto& table = tooth / 10 <= 2 ? kUpper : kLower;
  return {table[tooth % 10 - 1][0], table[tooth % 10 - 1][1]};
}

glm::dvec2 Turned(const glm::dvec2& p, double turn) {
  return {std::cos(turn) * p.x - std::sin(turn) * p.y, std::sin(turn) * p.x + std::cos(turn) * p.y};
}

Crown CrownOf(int tooth) {
  Crown crown;
  crown.shape = ShapeOf(tooth);
  const int model = tooth % 10 <= 3 ? 11 : tooth % 10 <= 5 ? 14 : 46;
  crown.scale = SizeOf(tooth) / SizeOf(model);
  return crown;
}

}  // namespace

int NextTooth(int tooth, bool mesially) {
  const int quadrant = tooth / 10, place = tooth % 10;
  if (!scene::IsToothNumber(tooth) || quadrant > 4) return 0;
  if (!mesially) return place < 8 ? tooth + 1 : 0;
  // 1 and 2, 3 and 4 meet at the midline.
  if (place == 1) return (quadrant % 2 == 1 ? quadrant + 1 : quadrant - 1) * 10 + 1;
  return tooth - 1;
}

TissueAt Crown::tissue() const {
  return [this](const dvec3& p_mm) {
    const glm::dvec2 own = Turned(glm::dvec2(p_mm) - middle, -turn_rad) / scale;
    const scene::FieldSample sample = scene::ToothField(shape, 1e-3 * dvec3(own, p_mm.z));
    return sample.distance_m < 0 ? sample.tissue : cutting::Tissue::kAir;
  };
}

Neck Crown::neck() const {
  const double line = shape.cervical_z;
  const auto& cap = shape.enamel;
  if (auto found = NeckOf(tissue(), middle, line - 1,
                          line + std::max(cap.mesial_rise, cap.distal_rise) + 1)) {
    return *found;
  }
  return WithMargin(tissue(), middle, Around(line + kAboveCementLine_mm));
}

render::GroupMesh Crown::Mesh(int32_t voxel_nm) const {
  auto [lo, hi] = scene::BoundsOf_m(shape);
  lo.z = 1e-3 * (shape.cervical_z - kBelowCementLine_mm);
  const cutting::Volume volume =
      scene::BuildVolume(scene::GridAround(lo, hi, voxel_nm),
                         [&](const dvec3& p) { return scene::ToothField(shape, p); });
  const surface::Mesh surface = surface::ExtractSurface(volume);
  render::GroupMesh out;
  render::Append(surface, render::ToothLooks(volume), out);
  for (size_t i = 0; i < out.vertices.size(); ++i) {
    const dvec3 p = 1e3 * dvec3(surface.position_m[i]), n(surface.normal[i]);
    const glm::dvec2 at = middle + Turned(glm::dvec2(p) * scale, turn_rad);
    const dvec3 normal = glm::normalize(dvec3(Turned(glm::dvec2(n) / scale, turn_rad), n.z));
    auto byte = [](double v) { return static_cast<int8_t>(std::lround(127 * v)); };
    render::GpuVertex& vertex = out.vertices[i];
    const std::array<double, 3> place = {at.x, at.y, p.z};
    for (int k = 0; k < 3; ++k) {
      vertex.position_mm[k] = static_cast<float>(place[static_cast<size_t>(k)]);
      vertex.normal[k] = byte(normal[k]);
    }
  }
  return out;
}

std::vector<Crown> NeighboursOf(int tooth, const std::array<double, 2>& half_mm) {
  std::vector<Crown> out;
  const double curve = 1 / (scene::IsAnterior(tooth) ? kFrontRadius_mm : kSideRadius_mm);
  for (const bool mesially : {true, false}) {
    const double side = mesially ? scene::MesialX(tooth) : -scene::MesialX(tooth);
    double along = half_mm[side > 0 ? 0 : 1];
    // Beyond the midline the way on is distal.
    bool toward_middle = mesially;
    int number = tooth;
    for (int i = 0; i < kEachSide; ++i) {
      const int next = NextTooth(number, toward_middle);
      if (next == 0) break;
      if (next / 10 != number / 10) toward_middle = false;
      number = next;
      Crown crown = CrownOf(number);
      const double half = 0.5 * SizeOf(number).x;
      along += half + kGap_mm;
      const double angle = curve * along;
      crown.middle = {side * std::sin(angle) / curve, (std::cos(angle) - 1) / curve};
      crown.turn_rad = -side * angle;
      along += half;
      out.push_back(std::move(crown));
    }
  }
  return out;
}

std::vector<Crown> RowOf(int tooth) {
  const double half = 0.5 * SizeOf(tooth).x;
  std::vector<Crown> out = NeighboursOf(tooth, {half, half});
  out.insert(out.begin(), CrownOf(tooth));
  return out;
}

}  // namespace enamel::station::mouth
