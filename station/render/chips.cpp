#include "station/render/chips.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "station/render/materials.h"

namespace enamel::station::render {
namespace {

using cutting::kTissueCount;
using cutting::Tissue;

// Chosen so that a grain stays within some millimetres of the cut while it lives: along the bur's
// axis at least as fast as sideways, so that it comes out of a slot.
constexpr float kAlongLeast_mm_per_s = 10, kAlongMost_mm_per_s = 30, kAsideMost_mm_per_s = 15;
// Less than true, as the speeds are. Up is +z in every scene.
const glm::vec3 kFall_mm_per_s2(0, 0, -150);

void Move(Chip& chip, float dt_s) {
  chip.at_mm += chip.mm_per_s * dt_s + kFall_mm_per_s2 * (0.5f * dt_s * dt_s);
  chip.mm_per_s += kFall_mm_per_s2 * dt_s;
  chip.age_s += dt_s;
}

bool GivesChips(size_t tissue) {
  return tissue != static_cast<size_t>(Tissue::kAir) &&
         tissue != static_cast<size_t>(Tissue::kPulp);
}

}  // namespace

float Chip::radius_mm() const {
  if (!alive()) return 0;
  const float share = age_s / life_s;
  return widest_mm * (1 - share * share);
}

void Chips::Step(float dt_s) {
  for (Chip& chip : all_) {
    if (chip.alive()) Move(chip, dt_s);
  }
}

Chip Chips::Leave(const cutting::Bur& bur, const cutting::Pose& pose) {
  const glm::mat3 scene_from_bur(pose.orientation.Matrix());
  const auto mm = [](double m) { return static_cast<float>(m * 1000); };
  const float turn = 6.2831853f * Unit();
  const glm::vec3 out = scene_from_bur * glm::vec3(std::cos(turn), std::sin(turn), 0);
  // How high the tooth touches the bur is not known here; its lowest part mostly does.
  const float up_mm = Unit() * std::min(mm(bur.height_m()), 2 * mm(bur.radius_m));
  Chip chip;
  chip.at_mm = glm::vec3(pose.tip_m * 1000.0) + mm(bur.radius_m) * out + up_mm * scene_from_bur[2];
  chip.mm_per_s = kAsideMost_mm_per_s * Unit() * out +
                  std::lerp(kAlongLeast_mm_per_s, kAlongMost_mm_per_s, Unit()) * scene_from_bur[2];
  chip.life_s = std::lerp(kShortest_s, kLongest_s, Unit());
  chip.widest_mm = std::lerp(0.5f, 1.0f, Unit()) * kWidest_mm;
  return chip;
}

void Chips::Add(const std::array<double, kTissueCount>& removed_mm3, const cutting::Bur& bur,
                const cutting::Pose& pose, float dt_s) {
  double wanted = 0;
  for (size_t t = 0; t < kTissueCount; ++t) {
    if (!GivesChips(t)) continue;
    owed_[t] += kPerMm3 * std::max(removed_mm3[t], 0.0);
    wanted += owed_[t];
  }
  // Each tissue has its share of as many as there can be.
  const double share = wanted > kMost ? kMost / wanted : 1;
  for (size_t t = 0; t < kTissueCount; ++t) {
    for (owed_[t] *= share; owed_[t] >= 1; --owed_[t]) {
      Chip& chip = all_[next_];
      next_ = (next_ + 1) % kMost;
      chip = Leave(bur, pose);
      chip.tissue = static_cast<Tissue>(t);
      // They left one after another, not all now.
      Move(chip, Unit() * dt_s);
    }
  }
}

void ShapeOf(std::span<const Chip> chips, Shape& shape) {
  // A tetrahedron, with the normals of a ball: no face is large enough to be seen as one.
  constexpr int8_t kNormal = 73;  // 127 / sqrt(3)
  constexpr std::array<std::array<int, 3>, 4> kCorners = {
      {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
  constexpr std::array<uint32_t, 12> kFaces = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
  shape.vertices.clear();
  shape.indices.clear();
  for (const Chip& chip : chips) {
    const float radius_mm = chip.radius_mm();
    if (radius_mm <= 0) continue;
    const auto first = static_cast<uint32_t>(shape.vertices.size());
    const Look look =
        LookOf(dvec3(TissueColour(chip.tissue)), kCutGloss * TissueGloss(chip.tissue));
    for (const auto& c : kCorners) {
      const glm::vec3 p = chip.at_mm + radius_mm * glm::vec3(c[0], c[1], c[2]) / std::sqrt(3.0f);
      const auto n = [&](int i) {
        return static_cast<int8_t>(kNormal * c[static_cast<size_t>(i)]);
      };
      shape.vertices.push_back({{p.x, p.y, p.z}, {n(0), n(1), n(2)}, kTooth, look});
    }
    for (const uint32_t i : kFaces) shape.indices.push_back(first + i);
  }
}

}  // namespace enamel::station::render
