#include "tests/common/import/made_jaw.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace enamel::import {
namespace {

constexpr double kRadius_mm = 26, kGap_mm = 0.6, kWall_mm = 0.8, kAcross_mm = 18;
constexpr double kSquare = 4;  // of the crowns' outlines: superellipses

dvec3 Across(const MadeCrown& crown) { return {-crown.along.y, crown.along.x, 0}; }

double Gum(const dvec3& p) {
  const double off = std::hypot(p.x, p.y) - kRadius_mm;
  return -0.03 * off * off;
}

double Height(const std::vector<MadeCrown>& crowns, const dvec3& p) {
  double z = Gum(p);
  for (const MadeCrown& crown : crowns) {
    const double in = std::clamp(-Outside_mm(crown, p) / kWall_mm, 0.0, 1.0);
    z = std::max(z, Gum(p) + crown.high_mm * in * in * (3 - 2 * in));
  }
  return z;
}

}  // namespace

double Outside_mm(const MadeCrown& crown, const dvec3& p) {
  const dvec3 d = p - crown.middle;
  const double x = Dot(d, crown.along) / (crown.width_mm / 2),
               y = Dot(d, Across(crown)) / (crown.depth_mm / 2);
  const double r =
      std::pow(std::pow(std::abs(x), kSquare) + std::pow(std::abs(y), kSquare), 1 / kSquare);
  const double flat = std::hypot(d.x, d.y);
  return r > 0 ? flat * (1 - 1 / r) : -std::min(crown.width_mm, crown.depth_mm) / 2;
}

MadeJaw MakeJaw(int crowns, int steps) {
  MadeJaw out;
  double at = -std::numbers::pi / 2;
  const double each = std::numbers::pi / crowns;
  for (int i = 0; i < crowns; ++i, at += each) {
    const double angle = at + each / 2;
    out.crowns.push_back({{kRadius_mm * std::cos(angle), kRadius_mm * std::sin(angle), 0},
                          {-std::sin(angle), std::cos(angle), 0},
                          2 * kRadius_mm * std::sin(each / 2) - kGap_mm,
                          7 + 2.0 * i / crowns,
                          5 + 1.5 * (i % 3) / 2});
  }
  const int across = steps / 4;
  for (int i = 0; i <= steps; ++i) {
    const double angle = -std::numbers::pi / 2 - 0.1 + (std::numbers::pi + 0.2) * i / steps;
    for (int k = 0; k <= across; ++k) {
      const double r = kRadius_mm - kAcross_mm / 2 + kAcross_mm * k / across;
      dvec3 p(r * std::cos(angle), r * std::sin(angle), 0);
      p.z = Height(out.crowns, p);
      out.mesh.vertices.push_back(p);
    }
  }
  auto index = [&](int i, int k) { return static_cast<uint32_t>(i * (across + 1) + k); };
  for (int i = 0; i < steps; ++i) {
    for (int k = 0; k < across; ++k) {
      out.mesh.indices.push_back({index(i, k), index(i, k + 1), index(i + 1, k + 1)});
      out.mesh.indices.push_back({index(i, k), index(i + 1, k + 1), index(i + 1, k)});
    }
  }
  return out;
}

double HeightAt(const MadeJaw& jaw, const dvec3& p) { return Height(jaw.crowns, p); }
double GumAt(const MadeJaw&, const dvec3& p) { return Gum(p); }

std::vector<dvec3> AlongGum(const MadeJaw& jaw, size_t crown, int points, double off_mm) {
  const MadeCrown& c = jaw.crowns[crown];
  std::vector<dvec3> out;
  for (int i = 0; i < points; ++i) {
    const double a = 2 * std::numbers::pi * i / points;
    const double r = std::pow(
        std::pow(std::abs(std::cos(a)), kSquare) + std::pow(std::abs(std::sin(a)), kSquare),
        -1 / kSquare);
    dvec3 p = c.middle + (c.width_mm / 2 * r * std::cos(a)) * c.along +
              (c.depth_mm / 2 * r * std::sin(a)) * Across(c);
    const dvec3 away = p - c.middle;
    p += off_mm * away / glm::length(away);
    p.z = Height(jaw.crowns, p);
    out.push_back(p);
  }
  return out;
}

}  // namespace enamel::import
