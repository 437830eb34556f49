#pragma once

#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "common/cutting/bur.h"
#include "common/surface/level_lines.h"
#include "station/render/mesher.h"

// Bodies of revolution to draw, about +z, in millimetres.
namespace enamel::station::render {

// Values of GpuVertex::tissue beyond the tissues.
enum Material : uint8_t {
  kBurHead = 8,
  kBurShank = 9,
  kForceArrow = 10,
  kTargetLine = 11,
  kGingiva = 12,     // the first of kGingivaShades: gingiva, mucosa in the middle, the mouth's dark
  kRubberDam = 213,  // the first of kRubberDamShades: from the sheet to nothing
  kTooth = 233,      // GpuVertex::look says which
};
// As in the shaders; from kGingivaDark on nothing is seen.
inline constexpr int kGingivaShades = 201, kGingivaDark = 190, kRubberDamShades = 20;

struct Shape {
  std::vector<GpuVertex> vertices;
  std::vector<uint32_t> indices;
};

// A body of revolution from its half outline, (radius, z) in mm, from the lower end upward.
Shape Revolve(const std::vector<glm::vec2>& outline, uint8_t material);
// Adds `shape`, moved rigidly, to `out`.
void Append(const Shape& shape, const glm::mat4& moved, Shape& out);

// Half outlines of a bur, (radius, z) in mm, from the distal end upward: the cutting head exactly
// as in the core, then neck and shank, for show only.
std::vector<glm::vec2> BurHeadOutline(const cutting::Bur& bur);
std::vector<glm::vec2> BurShankOutline(const cutting::Bur& bur);

// Bodies of these outlines, in the bur's own frame.
Shape BurHeadShape(const cutting::Bur& bur);
Shape BurShankShape(const cutting::Bur& bur);
// Unit cylinder and unit cone along +z, radius 1.
Shape ShaftShape();
Shape TipShape();
// A square rod around each segment, scene frame.
Shape LineShape(std::span<const surface::LineSegment> lines, float radius_mm);

}  // namespace enamel::station::render
