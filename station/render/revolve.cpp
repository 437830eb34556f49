#include "station/render/revolve.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>

#include "common/cutting/profile.h"

namespace enamel::station::render {
namespace {

// At 0.8 mm radius the outline is at most 1.7 um inside the circle.
constexpr int kAround = 48;

using Profile = std::vector<glm::vec2>;  // (radius, z), from the distal end upward

// Normal of a profile's segment, in (radius, z).
glm::vec2 SegmentNormal(const Profile& p, size_t i) {
  glm::vec2 d = p[i + 1] - p[i];
  return glm::normalize(glm::vec2(d.y, -d.x));
}

// Neighbouring segments share a normal where they meet at less than 35 degrees.
glm::vec2 NormalAt(const Profile& p, size_t segment, size_t neighbour) {
  glm::vec2 own = SegmentNormal(p, segment);
  if (neighbour + 1 >= p.size()) return own;
  glm::vec2 other = SegmentNormal(p, neighbour);
  return glm::dot(own, other) > 0.82f ? glm::normalize(own + other) : own;
}

void AppendRing(const glm::vec2& at, const glm::vec2& normal, uint8_t material, Shape& out) {
  for (int j = 0; j < kAround; ++j) {
    float a = 2 * std::numbers::pi_v<float> * static_cast<float>(j) / kAround, c = std::cos(a),
          s = std::sin(a);
    auto byte = [](float v) { return static_cast<int8_t>(std::lround(v * 127)); };
    out.vertices.push_back({{at.x * c, at.x * s, at.y},
                            {byte(normal.x * c), byte(normal.x * s), byte(normal.y)},
                            material});
  }
}

}  // namespace

Shape Revolve(const Profile& p, uint8_t material) {
  Shape out;
  for (size_t i = 0; i + 1 < p.size(); ++i) {
    auto base = static_cast<uint32_t>(out.vertices.size());
    AppendRing(p[i], NormalAt(p, i, i == 0 ? p.size() : i - 1), material, out);
    AppendRing(p[i + 1], NormalAt(p, i, i + 1), material, out);
    for (uint32_t j = 0; j < kAround; ++j) {
      uint32_t k = (j + 1) % kAround, a = base + j, b = base + k, c = base + kAround + k,
               d = base + kAround + j;
      out.indices.insert(out.indices.end(), {a, b, c, a, c, d});
    }
  }
  return out;
}

void Append(const Shape& shape, const glm::mat4& moved, Shape& out) {
  const auto first = static_cast<uint32_t>(out.vertices.size());
  for (GpuVertex v : shape.vertices) {
    const glm::vec3 p(moved * glm::vec4(v.position_mm[0], v.position_mm[1], v.position_mm[2], 1));
    const glm::vec3 n(moved * glm::vec4(v.normal[0], v.normal[1], v.normal[2], 0));
    for (int i = 0; i < 3; ++i) {
      v.position_mm[i] = p[i];
      v.normal[i] = static_cast<int8_t>(std::lround(n[i]));
    }
    out.vertices.push_back(v);
  }
  for (uint32_t i : shape.indices) out.indices.push_back(first + i);
}

Profile BurHeadOutline(const cutting::Bur& bur) {
  Profile p;
  auto add = [&](double r, double z) {
    p.emplace_back(static_cast<float>(std::max(0.0, r) * 1000), static_cast<float>(z * 1000));
  };
  add(0, 0);
  const cutting::Profile outline = cutting::ProfileOf(bur);
  for (const cutting::ProfilePiece& piece : outline.pieces()) {
    if (!piece.arc) {
      add(piece.to[0], piece.to[1]);
      continue;
    }
    // A corner: the adjacent lines meet there anyway.
    if (piece.radius == 0) continue;
    // Outward normals have r >= 0, so the angles are within a quarter turn of 0 and never wrap.
    double from = std::atan2(piece.first[1], piece.first[0]);
    double turn = std::atan2(piece.last[1], piece.last[0]) - from;
    for (int i = 1; i <= 24; ++i) {
      double a = from + turn * i / 24;
      add(piece.at[0] + piece.radius * std::cos(a), piece.at[1] + piece.radius * std::sin(a));
    }
  }
  return p;
}

Profile BurShankOutline(const cutting::Bur& bur) {
  auto r = static_cast<float>(bur.radius_m * 1000), top = static_cast<float>(bur.height_m() * 1000);
  bool sphere = bur.shape == cutting::BurShape::kSphere;
  float neck = std::min(0.6f * r, 0.45f), start = sphere ? top - 0.15f * r : top;
  return {{sphere ? neck : 0.9f * r, start},
          {neck, start + 0.5f},
          {neck, start + 2.5f},
          {0.8f, start + 4.0f},
          {0.8f, start + 16.0f},
          {0, start + 16.0f}};
}

Shape BurHeadShape(const cutting::Bur& bur) { return Revolve(BurHeadOutline(bur), kBurHead); }
Shape BurShankShape(const cutting::Bur& bur) { return Revolve(BurShankOutline(bur), kBurShank); }

Shape ShaftShape() { return Revolve({{0, 0}, {1, 0}, {1, 1}}, kForceArrow); }
Shape TipShape() { return Revolve({{0, 0}, {1, 0}, {0, 1}}, kForceArrow); }

Shape LineShape(std::span<const surface::LineSegment> lines, float radius_mm) {
  Shape shape;
  for (const surface::LineSegment& line : lines) {
    const glm::vec3 from = line.from_m * 1000.0f, to = line.to_m * 1000.0f;
    const float length = glm::length(to - from);
    if (!(length > 0)) continue;
    const glm::vec3 z = (to - from) / length;
    const glm::vec3 x = glm::normalize(
        glm::cross(std::fabs(z.x) < 0.7f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0), z));
    const glm::vec3 y = glm::cross(z, x);
    const auto first = static_cast<uint32_t>(shape.vertices.size());
    for (const glm::vec3& side : {x, y, -x, -y}) {
      for (const glm::vec3& end : {from, to}) {
        const glm::vec3 p = end + radius_mm * side;
        auto byte = [](float v) { return static_cast<int8_t>(std::lround(127 * v)); };
        shape.vertices.push_back(
            {{p.x, p.y, p.z}, {byte(side.x), byte(side.y), byte(side.z)}, kTargetLine});
      }
    }
    for (uint32_t side = 0; side < 4; ++side) {
      const uint32_t a = first + 2 * side, b = first + 2 * ((side + 1) % 4);
      shape.indices.insert(shape.indices.end(), {a, b, b + 1, a, b + 1, a + 1});
    }
  }
  return shape;
}

}  // namespace enamel::station::render
