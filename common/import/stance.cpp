#include "common/import/stance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/import/likeness.h"

namespace enamel::import {
namespace {

// All of these were chosen on teeth made by formula (tests/common/import/made_teeth.h) and hold on
// others of other seeds, and on scanned crowns that had no part in it (StanceTest).
constexpr double kAgrees = 0.7;          // cosine: 45 degrees
constexpr double kAgainst = 0.3;         // cosine below which a kind contradicts
constexpr double kLikenessWeight = 2.5;  // of a cost's logarithm
constexpr double kFormWeight = 1.0, kHollowWeight = 0.5, kHoleWeight = 1.5;
constexpr double kSurelyAlike = 1.35;  // cost of another direction over the best one's
constexpr double kFullHollow = 0.5, kShallow_mm = 0.01, kFullDrift = 0.05;
constexpr double kMinHole = 0.04;  // of the surface; smaller ones are a scanner's gaps
constexpr double kWeakForm = 0.3;
constexpr double kOnAxis = 0.866;  // 30 degrees

// A direction and how much it says, 0 to 1.
struct Evidence {
  dvec3 along{0};
  double weight = 0;
  double For(const dvec3& up) const { return weight * Dot(along, up); }
};

Evidence Of(const dvec3& v, double weight) {
  const double length = glm::length(v);
  return length > 0 ? Evidence{v / length, std::clamp(weight, 0.0, 1.0)} : Evidence{};
}

// The nearest axis of the file, where it is near.
dvec3 Straight(const dvec3& up) {
  for (int k = 0; k < 3; ++k) {
    if (std::abs(up[k]) < kOnAxis) continue;
    dvec3 axis(0);
    axis[k] = up[k] > 0 ? 1 : -1;
    return axis;
  }
  return up;
}

}  // namespace

std::string_view WitnessName(Witness witness) {
  constexpr std::array<std::string_view, 5> kNames = {"likeness", "taper", "hollows", "hole",
                                                      "enamel"};
  return kNames[static_cast<size_t>(witness)];
}

FoundStance FindStance(const mesh::Solid& solid, int tooth) {
  const std::vector<Likeness> alike = LikeOwnTooth(solid.mesh, mesh::Select(solid, false), tooth);
  const bool front = tooth % 10 <= 3;
  const mesh::Hollows hollows = mesh::HollowsOf(solid.mesh);
  const double deep = hollows.depth / (hollows.depth + kShallow_mm);
  const Evidence hollow = Of(hollows.facing, deep * glm::length(hollows.facing) / kFullHollow);
  const dvec3 drift = mesh::DriftOf(solid.mesh);
  const Evidence form = front ? Of(drift, glm::length(drift) / kFullDrift) : hollow;
  const std::optional<dvec3> faces = HoleOf(solid);
  const Evidence hole = faces ? Of(-*faces, 1) : Evidence{};

  std::vector<Likeness> candidates = alike;
  auto score = [&](const Likeness& l) {
    return -kLikenessWeight * std::log(l.cost / alike.front().cost) +
           kFormWeight * form.For(l.up()) + (front ? kHollowWeight * hollow.For(l.up()) : 0) +
           kHoleWeight * hole.For(l.up());
  };
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](const Likeness& l, const Likeness& r) { return score(l) > score(r); });
  const dvec3 up = candidates.front().up();

  FoundStance out;
  const bool by_likeness = Dot(up, alike.front().up()) > kAgrees;
  const bool by_form = form.weight > kWeakForm && Dot(up, form.along) > kAgrees;
  const bool by_hole = hole.weight > 0 && Dot(up, hole.along) > kAgrees;
  const bool form_against = form.weight > kWeakForm && Dot(up, form.along) < kAgainst;
  const bool likeness_against =
      !by_likeness && candidates.front().cost > kSurelyAlike * alike.front().cost;
  const bool hole_against = hole.weight > 0 && Dot(up, hole.along) < kAgainst;
  const int kinds = by_likeness + by_form + by_hole;
  out.stance = mesh::StanceWithUp(solid.mesh, Straight(up));
  out.stance.certain = kinds >= 2 && !likeness_against && !hole_against &&
                       !(form_against && !(by_likeness && by_hole));
  if (by_likeness) out.by.push_back(Witness::kLikeness);
  if (by_form) out.by.push_back(front ? Witness::kTaper : Witness::kHollows);
  if (by_hole) out.by.push_back(Witness::kHole);
  return out;
}

std::optional<dvec3> HoleOf(const mesh::Solid& solid) {
  dvec3 caps(0);
  double area = 0;
  for (const auto& t : solid.mesh.indices) {
    const dvec3& a = solid.mesh.vertices[t[0]];
    const dvec3 normal = glm::cross(solid.mesh.vertices[t[1]] - a, solid.mesh.vertices[t[2]] - a);
    area += glm::length(normal);
    if (mesh::IsCap(solid, t)) caps += normal;
  }
  const double length = glm::length(caps);
  return length >= kMinHole * area ? std::optional(caps / length) : std::nullopt;
}

}  // namespace enamel::import
