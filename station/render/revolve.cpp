#include "station/render/revolve.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace enamel::station::render {
namespace {

constexpr int kAround = 48;
constexpr float kPi = 3.14159265f;

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
    float a = 2 * kPi * static_cast<float>(j) / kAround, c = std::cos(a), s = std::sin(a);
    auto byte = [](float v) { return static_cast<int8_t>(std::lround(v * 127)); };
    out.vertices.push_back({{at.x * c, at.x * s, at.y},
                            {byte(normal.x * c), byte(normal.x * s), byte(normal.y)},
                            material});
  }
}

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

}  // namespace

Shape BurHeadShape(const cutting::Bur& bur) {
  auto r = static_cast<float>(bur.radius_m * 1000),
       length = static_cast<float>(bur.height_m() * 1000);
  Profile p;
  if (bur.shape == cutting::BurShape::kSphere) {
    for (int i = 0; i <= 24; ++i) {
      float a = kPi * static_cast<float>(i) / 24;
      p.emplace_back(r * std::sin(a), r - r * std::cos(a));
    }
  } else {
    p = {{0, 0}, {r, 0}, {r, length}, {0, length}};
  }
  return Revolve(p, kBurHead);
}

Shape BurShankShape(const cutting::Bur& bur) {
  auto r = static_cast<float>(bur.radius_m * 1000), top = static_cast<float>(bur.height_m() * 1000);
  bool sphere = bur.shape == cutting::BurShape::kSphere;
  float neck = std::min(0.6f * r, 0.45f), start = sphere ? top - 0.15f * r : top;
  return Revolve({{sphere ? neck : 0.9f * r, start},
                  {neck, start + 0.5f},
                  {neck, start + 2.5f},
                  {0.8f, start + 4.0f},
                  {0.8f, start + 16.0f},
                  {0, start + 16.0f}},
                 kBurShank);
}

Shape ShaftShape() { return Revolve({{0, 0}, {1, 0}, {1, 1}}, kForceArrow); }
Shape TipShape() { return Revolve({{0, 0}, {1, 0}, {0, 1}}, kForceArrow); }

}  // namespace enamel::station::render
