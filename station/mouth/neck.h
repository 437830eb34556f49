#pragma once

#include <array>
#include <functional>
#include <glm/vec2.hpp>
#include <optional>

#include "common/cutting/tissue.h"
#include "common/math/vec.h"

namespace enamel::station::mouth {

// What is at a point of a tooth's own frame, crown up, in millimetres; kAir outside.
using TissueAt = std::function<cutting::Tissue(const dvec3& own_mm)>;

// A value for each direction around a tooth's axis; periodic, a Catmull-Rom curve between them.
class Around {
 public:
  static constexpr size_t kCount = 96;

  Around() = default;
  explicit Around(double value) { values_.fill(value); }
  double& operator[](size_t i) { return values_[i]; }
  double operator[](size_t i) const { return values_[i]; }
  // Direction of a sample, rad; 0 along +x.
  static double Angle(size_t i);
  // The sample next to a direction.
  static size_t Nearest(double angle_rad);
  double At(double angle_rad) const;
  // Mean over neighbouring directions, of a Gauss curve of this deviation.
  Around Smoothed(double deviation_rad) const;
  double Mean() const;

 private:
  std::array<double, kCount> values_{};
};

// A tooth's neck as seen along its axis: where the gingiva meets it.
struct Neck {
  glm::dvec2 middle_mm{0};
  Around margin_mm;  // height of the gingival margin
  Around radius_mm;  // of the tooth there, from its middle
  Around girth_mm;   // that without its hollows, as what is farther out follows it
  Around ridge_mm;   // the margin without its scallops, as the ridge farther out follows it
};

// Distance from the tooth's side at its margin, seen along its axis: its outline at the tooth, and
// rounder farther out. Less than 0 inside.
double FromTooth_mm(const Neck& neck, double x, double y);
// Over how far.
inline constexpr double kScallops_mm = 3;

// A healthy margin is this far above the cement line: the junctional epithelium, 0.97, ends there,
// and the sulcus, 0.69, is above it (Gargiulo, Wentz & Orban, J. Periodontol. 32, 1961: means of
// 30 jaws).
inline constexpr double kAboveCementLine_mm = 0.97 + 0.69;

// Distance from a tooth's axis to its surface; 0 where the axis is outside.
double RadiusAt_mm(const TissueAt& tissue, const glm::dvec2& middle_mm, double angle_rad,
                   double height_mm);

// From the cement line between `lowest_mm` and `highest_mm`: the lowest enamel on the surface in each
// direction. None where most directions have no such line.
std::optional<Neck> NeckOf(const TissueAt& tissue, const glm::dvec2& middle_mm, double lowest_mm,
                           double highest_mm);

// The same tooth with its margin at these heights.
Neck WithMargin(const TissueAt& tissue, const glm::dvec2& middle_mm, const Around& margin_mm);

}  // namespace enamel::station::mouth
